#include "tools/brittle/stage/classify_choice.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <optional>

#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/base/interrupt.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

namespace {

constexpr int measured = 3; // number of fractures with each processor after one warm-up; the fastest counts

// Returns the duration of the whole fracture, ms; nothing if the device failed.
std::optional<double> measure(const Input& input, const FractureOptions& options, engine::GpuClassifier* classifier) {
    double best = std::numeric_limits<double>::infinity();
    for (int k = 0; k <= measured; ++k) {
        const double milliseconds = break_input(input, options, {}, classifier, is_interrupted).milliseconds;
        if (classifier && !classifier->error().empty()) return std::nullopt;
        if (k > 0) best = std::min(best, milliseconds);
    }
    return best;
}

std::string say(const char* text, double a, double b) {
    char buffer[100];
    std::snprintf(buffer, sizeof buffer, text, a, b);
    return buffer;
}

} // namespace

ClassifyPath classify_path(const std::string& word) {
    if (word == "auto") return ClassifyPath::automatic;
    if (word == "cpu") return ClassifyPath::cpu;
    if (word == "gpu") return ClassifyPath::gpu;
    throw Failure(exit_usage, "'" + word + "' is not a processor to classify on; give auto, cpu or gpu");
}

ClassifyChoice choose_classifier(ClassifyPath path, engine::Device& device, const Input& input,
                                 const FractureOptions& options) {
    if (path == ClassifyPath::cpu) return {.why = "cpu, as requested"};
    if (path == ClassifyPath::automatic && (options.algorithm != fracture::Algorithm::exact || !input.weights.empty()))
        return {.why = "cpu: the device classifies for unweighted sites and the exact algorithm only"};
    auto made = engine::GpuClassifier::create(device);
    if (!made) {
        if (path == ClassifyPath::gpu) throw failure_of(made.error());
        return {.why = "cpu: " + made.error().message};
    }
    ClassifyChoice choice{std::move(*made), "gpu, as requested"};
    if (path == ClassifyPath::gpu) return choice;
    const double on_cpu = *measure(input, options, nullptr);
    const std::optional<double> on_device = measure(input, options, choice.classifier.get());
    if (!on_device) return {.why = "cpu: " + choice.classifier->error()};
    if (*on_device < on_cpu) {
        choice.why = say("gpu: the fracture takes %.1f ms, on the CPU %.1f ms", *on_device, on_cpu);
        return choice;
    }
    return {.why = say("cpu: the fracture takes %.1f ms, with the device %.1f ms", on_cpu, *on_device)};
}

} // namespace brittle::tools
