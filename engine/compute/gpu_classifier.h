// Classification on the device: which cell each vertex lies in, which triangles cross bisectors, and how.
//
//     Result<std::unique_ptr<GpuClassifier>> classifier = GpuClassifier::create(device);
//     settings.classifier = classifier->get();
//
// A grid of sites keeps the cost per vertex from growing with their number. The device works in float32 while
// the CPU builds the Voronoi cells, and marks what that precision cannot decide (see fracture/classifier.h). Crossing
// triangles are gathered in a list, so that the searches for their signs (one for each edge, and one for the point
// where three cells meet) fill whole subgroups; all of it needs nothing of the CPU's, so one submission does it.
// A failure of the device (lost, out of memory) makes start() or finish() return false, and the CPU does it
// all; error() says why.
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
    // Errors: device_lost, out_of_memory and whatever else making pipelines can bring. The device must
    // outlive it.
    [[nodiscard]] static Result<std::unique_ptr<GpuClassifier>> create(Device& device);
    ~GpuClassifier() override;

    bool start(const Problem& problem) override;
    bool finish(std::span<uint32_t> site_of_vertex, std::span<uint32_t> site_of_triangle) override;

    // Of the last fracture, on the device's clock; empty where it has none.
    [[nodiscard]] const std::vector<PassTime>& timings() const;
    // Why the last start() or finish() returned false.
    [[nodiscard]] const std::string& error() const;

  private:
    struct State;
    explicit GpuClassifier(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

} // namespace brittle::engine
