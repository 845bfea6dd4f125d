// The processor that classifies the vertices and triangles of a fracture: the CPU, the Vulkan device, or the faster one
// by measurement. The pieces are the same in each case.
#pragma once

#include <memory>
#include <string>

#include "engine/compute/gpu_classifier.h"
#include "tools/scenario/recipe/input.h"

namespace brittle::engine {
class Device;
}

namespace brittle::tools {

enum class ClassifyPath { automatic, cpu, gpu };

// Parses cpu, gpu or auto. Throws a Failure with exit_usage for another word.
[[nodiscard]] ClassifyPath classify_path(const std::string& word);

struct ClassifyChoice {
    std::unique_ptr<engine::GpuClassifier> classifier{}; // null: the CPU
    std::string why;                                     // reason for people, e.g. "cpu: 4.6 ms, on the device 17.2 ms"
};

// Returns the classifier of the given path. With ClassifyPath::automatic, fractures the input a few times with each
// processor and takes the faster one: the time of the whole fracture decides, because the device works while the CPU
// builds the cells. ClassifyPath::gpu throws a Failure with exit_environment if the device cannot classify. The device
// must outlive the result.
[[nodiscard]] ClassifyChoice choose_classifier(ClassifyPath path, engine::Device& device, const Input& input,
                                               const FractureOptions& options);

} // namespace brittle::tools
