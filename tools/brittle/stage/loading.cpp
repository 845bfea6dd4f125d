#include "tools/brittle/stage/loading.h"

#include "tools/brittle/base/console.h"
#include "tools/brittle/base/interrupt.h"
#include "tools/brittle/stage/mesh_looks.h"
#include "tools/brittle/stage/standard_streams.h"

namespace brittle::tools {

Host program_host() {
    return {.cancelled = is_interrupted,
            .report = [](const std::string& text) { tell("%s", text.c_str()); },
            .standard_input = read_standard_mesh};
}

Host drawing_host() {
    Host host = program_host();
    host.looks = {.materials = [](const fracture::Model& model,
                                  std::vector<std::string>& notes) { return materials_of(model, notes); },
                  .looks = looks_of};
    return host;
}

Input open_input(const FractureOptions& options, bool with_looks) {
    const InterruptDeadline deadline; // nothing is lost yet
    return load_input(options, with_looks, program_host());
}

LoadedScene open_scene(const FractureOptions& options, const Host& host, SceneCache* cache, bool with_looks) {
    const InterruptDeadline deadline;
    return load_scene(options, host, cache, with_looks);
}

} // namespace brittle::tools
