// Where a fracture's vertices and triangles are classified: on the CPU, on the device, or wherever it was measured to be
// faster. The pieces are the same.
#pragma once

#include <memory>
#include <string>

#include "engine/compute/gpu_classifier.h"
#include "tools/brittle/recipe/input.h"

namespace brittle::engine {
class Device;
}

namespace brittle::tools {

enum class ClassifyPath { automatic, cpu, gpu };

// cpu, gpu or auto. Throws a Failure with exit_usage for another word.
[[nodiscard]] ClassifyPath classify_path(const std::string& word);

struct ClassifyChoice {
    std::unique_ptr<engine::GpuClassifier> classifier{}; // null: the CPU
    std::string why;                                     // for people, e.g. "cpu: 4.6 ms, on the device 17.2 ms"
};

// With ClassifyPath::automatic this fractures the input a few times each way, which tells more than any estimate: what
// counts is the whole fracture, because the device works while the CPU builds the cells. Only what was asked for
// by name fails where the device cannot do it (Failure with exit_environment). The device must outlive the choice.
[[nodiscard]] ClassifyChoice choose_classifier(ClassifyPath path, engine::Device& device, const Input& input,
                                               const FractureOptions& options);

} // namespace brittle::tools
