// Finds what broke in a run, and throws off particles there: along the new faces of pieces that were cut, and where
// bonds broke. The particles meet the bodies of the run where these are at the end of the frame.
//
//     BreakParticles particles;
//     particles.start(simulation);                           // a run begins
//     each frame, after some steps of the simulation:
//         particles.advance(simulation);
//         for (const physics::PieceAdded& added : events.added) particles.cut(simulation, added);
//     particles.draw(alpha, splinters, dust);
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "engine/render/scene.h"
#include "physics/bonds/structure.h"
#include "physics/cutting/destruction.h"
#include "physics/material.h"
#include "physics/world/world.h"
#include "tools/brittle/stage/particles.h"
#include "tools/brittle/stage/piece_drawing.h"
#include "tools/scenario/run/simulation.h"

namespace brittle::tools {

// What a material throws off; null: a mesh without material.
[[nodiscard]] ParticleLook particle_look(const physics::MaterialPreset* material, const engine::SurfaceLook& surface);

class BreakParticles {
  public:
    // Share of the particles that are thrown off, 0 to 1; 0: none, and no time is spent.
    void set_amount(float amount) { amount_ = amount; }
    // Forgets all particles, and takes the bonds of the run as they are. `looks`: by object of the simulation.
    void start(const Simulation& simulation, std::vector<ParticleLook> looks);
    // Takes as many steps as the simulation has since the last call, then looks for bonds that broke.
    void advance(const Simulation& simulation);
    // Throws off particles along the new faces of a piece.
    void cut(const Simulation& simulation, const physics::PieceAdded& added, std::span<const CrackPoint> cracks);
    void draw(float alpha, std::vector<engine::Splinter>& splinters, std::vector<engine::DustPuff>& dust) const {
        if (amount_ > 0.0f) particles_.draw(alpha, splinters, dust);
    }
    [[nodiscard]] bool empty() const { return particles_.empty(); }

  private:
    struct Bonds {                       // of a structure
        std::vector<bool> live;          // by bond
        std::vector<uint32_t> object_of; // by piece: the object of the simulation
    };
    void note_object(const Simulation& simulation, uint32_t piece);
    void watch(const Simulation& simulation, const physics::Structure& structure, Bonds& bonds);
    [[nodiscard]] ParticleLook look_of(uint32_t object) const;
    void find_obstacles(const physics::World& world, std::span<const Way> ways, std::span<std::optional<Obstacle>> met);

    Particles particles_;
    std::map<const physics::Structure*, Bonds> bonds_;
    std::vector<ParticleLook> looks_;
    float amount_ = 0.0f;
    uint64_t steps_ = 0;             // of the simulation
    std::vector<physics::Ray> rays_; // scratch of find_obstacles(), with the next line
    std::vector<std::optional<physics::RayHit>> hits_;
};

} // namespace brittle::tools
