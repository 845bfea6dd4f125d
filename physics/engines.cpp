// Creates the engine of a World. The one file that includes both engines.
#include "physics/bullet/bullet_engine.h"
#include "physics/solver/solver.h"
#include "physics/world/engine.h"

namespace brittle::physics {

std::unique_ptr<Engine> make_engine(const WorldSettings& settings) {
    return settings.engine == EngineKind::bullet ? make_bullet_engine(settings) : make_solver(settings);
}

} // namespace brittle::physics
