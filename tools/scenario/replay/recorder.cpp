#include "tools/scenario/replay/recorder.h"

#include <cstdio>
#include <span>
#include <utility>

#include "fracture/io/atomic_file.h"
#include "tools/scenario/base/environment.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

Recorder::Recorder(std::filesystem::path file, const FractureOptions& options, Host host)
    : file_(std::move(file)), options_(options), host_(std::move(host)) {}

Recorder::~Recorder() {
    if (finished_ || file_.empty() || text_.empty()) return;
    const std::string log = text(file_, host_.cancelled && host_.cancelled() ? "interrupted" : "failed");
    const auto written = fracture::write_file_atomically(file_, std::as_bytes(std::span(log)));
    if (host_.report) host_.report(written ? file_.string() + " holds the run up to here" : written.error().message);
}

void Recorder::finish() {
    finished_ = true;
    if (file_.empty() || text_.empty()) return;
    save(file_);
}

void Recorder::save(const std::filesystem::path& file) const {
    if (text_.empty()) throw Failure(exit_usage, "there is no run to save yet: break the mesh first");
    const std::string log = text(file, "finished");
    must(fracture::write_file_atomically(file, std::as_bytes(std::span(log))));
}

std::string Recorder::text(const std::filesystem::path& file, const std::string& end) const {
    return header_line(header_, std::filesystem::absolute(file).parent_path()) + text_ + end_line(steps_, end);
}

void Recorder::started(const Simulation& simulation, std::span<const PreparedObject> objects,
                       const WorldOptions& world) {
    header_ = {.build = environment(),
               .step_seconds = static_cast<double>(simulation.world().settings().step),
               .pieces = simulation.piece_count(),
               .pieces_hash = pieces_hash(objects),
               .recipe = options_};
    header_.recipe.world = world;
    header_.recipe.world.shots.clear();
    text_.clear();
    checks_ = {};
    finished_ = false;
    add_state(simulation);
}

void Recorder::acted(uint64_t step, const Action& action) {
    text_ += action_line(step, action);
}

void Recorder::stepped(const Simulation& simulation) {
    for (const physics::Commit& commit : simulation.commits()) text_ += commit_line(commit);
    add_state(simulation);
}

void Recorder::add_state(const Simulation& simulation) {
    steps_ = simulation.steps();
    text_ += state_line(steps_, {simulation.state_hash(), checks_.next(simulation.world())});
}

} // namespace brittle::tools
