// Classification on the GPU: the Voronoi cell of each vertex, the triangles that cross bisectors, and the sign patterns
// of those triangles.
//
//     Result<std::unique_ptr<GpuClassifier>> classifier = GpuClassifier::create(device);
//     settings.classifier = classifier->get();
//
// The device works in float32 while the CPU builds the Voronoi cells, and marks answers that this precision cannot
// decide (fracture/classifier.h). A uniform grid of sites makes the cost per vertex independent of their number.
// Crossing triangles are compacted into a list, so that the searches for their signs (one for each edge, and one for
// the point where three cells meet) fill whole subgroups. One submission does all passes.
//
// When the device fails (lost, out of memory), start() or finish() returns false, the CPU classifies everything, and
// error() holds the reason. Not thread-safe.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "engine/graph/pass_time.h"
#include "fracture/classifier.h"

namespace brittle::engine {

class Device;

class GpuClassifier final : public fracture::Classifier {
  public:
    // Fails with device_lost, out_of_memory or device_failure. The device must outlive the classifier.
    [[nodiscard]] static Result<std::unique_ptr<GpuClassifier>> create(Device& device);
    ~GpuClassifier() override;

    bool start(const Problem& problem) override;
    bool finish(std::span<uint32_t> site_of_vertex, std::span<uint32_t> site_of_triangle) override;

    // Returns the times of the last classification; empty on a device without timestamps.
    [[nodiscard]] const std::vector<PassTime>& timings() const;
    // Returns the reason why the last start() or finish() returned false; empty after success.
    [[nodiscard]] const std::string& error() const;

  private:
    struct State;
    explicit GpuClassifier(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

} // namespace brittle::engine
