#include "tools/scenario/run/state_export.h"

#include <map>
#include <span>
#include <utility>

#include <glm/geometric.hpp>

#include "fracture/io/export.h"
#include "fracture/pieces/certificate.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

namespace {

// First value of Fragments::vertex_point for points that are not vertices of the input.
constexpr uint32_t first_cut_point = 1u << 30;

std::vector<Snapshot::Piece> pieces_there(const Simulation& simulation, size_t whole_pieces) {
    std::map<uint32_t, physics::Pose> poses; // poses by slot
    simulation.visit_poses(1.0f, 0, [&](uint32_t slot, const physics::Pose& pose) { poses[slot] = pose; });
    std::vector<Snapshot::Piece> pieces;
    const auto add = [&](uint32_t number, uint32_t slot, physics::SolidPtr solid) {
        if (const auto pose = poses.find(slot); pose != poses.end())
            pieces.push_back({number, std::move(solid), pose->second});
    };
    if (const physics::Destruction* destruction = simulation.destruction()) {
        for (const physics::PieceId id : destruction->pieces())
            add(id.value, destruction->slot(id), destruction->solid(id));
    } else {
        for (uint32_t piece = 0; piece < whole_pieces; ++piece) add(piece, piece, nullptr);
    }
    return pieces;
}

// Precondition: the pieces are of one object.
std::vector<fracture::Bond> bonds_that_hold(const Simulation& simulation, const std::vector<Snapshot::Piece>& pieces) {
    std::vector<fracture::Bond> bonds;
    const physics::Structure* structure = nullptr;
    physics::PartPlacement placement; // glued objects share a structure
    std::map<uint32_t, uint32_t> at;  // index into `pieces` by number in the structure
    for (uint32_t k = 0; k < pieces.size(); ++k) {
        const auto [own, number] = simulation.bonds_of(pieces[k].number);
        if (!own) continue;
        structure = own;
        if (const physics::Destruction* destruction = simulation.destruction())
            placement = destruction->placement_in_structure(destruction->object({pieces[k].number}));
        at[number] = k;
    }
    if (!structure) return bonds;
    for (const physics::BondGraph::Bond& bond : structure->graph().bonds()) {
        const auto a = at.find(bond.a), b = at.find(bond.b);
        if (bond.live() && a != at.end() && b != at.end())
            bonds.push_back({a->second, b->second, bond.area, placement.to_part(bond.centroid),
                             glm::conjugate(placement.turn) * bond.normal});
    }
    return bonds;
}

// Builds LivePieces piece by piece.
class Builder {
  public:
    Builder(const Snapshot& state, const StagePlacement& placement) : state_(state), placement_(placement) {}

    LivePieces build() {
        for (const Snapshot::Piece& piece : state_.pieces) {
            piece.solid ? add_solid(piece.number, *piece.solid) : add_fragment(state_.fragments->pieces[piece.number]);
            made_.poses.push_back({placement_.to_file(glm::dvec3(piece.pose.position)),
                                   glm::normalize(glm::dquat(piece.pose.orientation))});
        }
        const double s = placement_.scale;
        for (fracture::Bond bond : state_.bonds) {
            bond.area /= s * s;
            bond.centroid = placement_.to_file(bond.centroid);
            made_.fragments.bonds.push_back(bond);
        }
        return std::move(made_);
    }

  private:
    void add_solid(uint32_t number, const physics::SolidPiece& solid) {
        const physics::SolidSurface& surface = solid.surface();
        fracture::Fragments& to = made_.fragments;
        fracture::Piece piece{.site = number,
                              .vertices = {vertices(), 0},
                              .triangles = {triangles(), 0},
                              .exterior_triangles = surface.exterior_triangles,
                              .mass = in_file(solid.mass)};
        const glm::dvec3 centre = solid.mass.centre_of_mass;
        for (size_t v = 0; v < surface.positions.size(); ++v) {
            const bool kept = !surface.mesh.positions.empty(); // positions in double precision are available
            to.positions.push_back(
                placement_.to_file(kept ? surface.mesh.positions[v] : centre + glm::dvec3(surface.positions[v])));
            to.vertex_point.push_back(first_cut_point + vertices() - 1);
        }
        to.triangles.insert(to.triangles.end(), surface.mesh.triangles.begin(), surface.mesh.triangles.end());
        to.triangle_source.insert(to.triangle_source.end(), surface.source.begin(), surface.source.end());
        // Only tells the cuts apart: the piece across is no longer known.
        to.triangle_source.insert(to.triangle_source.end(), surface.cut.begin(), surface.cut.end());
        finish(piece);
    }

    void add_fragment(const fracture::Piece& from) {
        const fracture::Fragments& whole = *state_.fragments;
        fracture::Fragments& to = made_.fragments;
        fracture::Piece piece = from;
        piece.vertices.begin = vertices();
        piece.triangles = fracture::append_range(whole.triangles, from.triangles, to.triangles);
        for (uint32_t v = from.vertices.begin; v < from.vertices.end; ++v)
            to.positions.push_back(placement_.to_file(whole.positions[v]));
        fracture::append_range(whole.vertex_point, from.vertices, to.vertex_point);
        fracture::append_range(whole.triangle_source, from.triangles, to.triangle_source);
        piece.mass = in_file(from.mass);
        finish(piece);
    }

    void finish(fracture::Piece& piece) {
        piece.vertices.end = vertices();
        piece.triangles.end = triangles();
        made_.fragments.pieces.push_back(piece);
    }

    [[nodiscard]] uint32_t vertices() const { return static_cast<uint32_t>(made_.fragments.positions.size()); }
    [[nodiscard]] uint32_t triangles() const { return static_cast<uint32_t>(made_.fragments.triangles.size()); }

    [[nodiscard]] fracture::MassProperties in_file(fracture::MassProperties mass) const {
        const double s = placement_.scale;
        mass.volume /= s * s * s;
        mass.area /= s * s;
        mass.inertia /= s * s * s * s * s;
        mass.centre_of_mass = placement_.to_file(mass.centre_of_mass);
        return mass;
    }

    const Snapshot& state_;
    const StagePlacement& placement_;
    LivePieces made_;
};

void stop_if(const std::function<bool()>& cancelled) {
    if (cancelled && cancelled()) throw Failure(exit_interrupted, "writing the pieces was cancelled");
}

// Moves planes from the stage to the file.
std::vector<physics::HullPlane> in_file(std::span<const physics::HullPlane> planes, const StagePlacement& placement) {
    std::vector<physics::HullPlane> moved;
    for (const physics::HullPlane& plane : planes)
        moved.push_back({plane.normal, glm::dot(plane.normal, placement.to_file(plane.distance * plane.normal))});
    return moved;
}

// Returns the collision hulls of each piece. Pieces that no blow cut are cut along the contacts that they had before the
// run, whatever bonds are left.
std::vector<std::vector<fracture::TriangleMesh>> hulls_of(const Snapshot& state, const fracture::Fragments& fragments,
                                                          const StagePlacement& placement,
                                                          const physics::HullMeshSettings& settings,
                                                          const std::function<bool()>& cancelled) {
    std::vector<std::vector<physics::HullPlane>> planes;
    if (state.fragments) planes = physics::contact_planes(*state.fragments);
    std::vector<std::vector<fracture::TriangleMesh>> hulls;
    for (size_t p = 0; p < state.pieces.size(); ++p) {
        stop_if(cancelled);
        std::vector<physics::HullPlane> own;
        if (!state.pieces[p].solid) own = in_file(planes[state.pieces[p].number], placement);
        hulls.push_back(physics::hull_meshes(fragments, fragments.pieces[p], own, settings));
    }
    return hulls;
}

// Checks that the source has all triangles that the exterior triangles of the pieces refer to for their looks.
void check_source(const fracture::Fragments& fragments, const Input& source) {
    for (const fracture::Piece& piece : fragments.pieces)
        for (uint32_t t = 0; t < piece.exterior_triangles; ++t)
            if (fragments.triangle_source[piece.triangles.begin + t] >= source.model.mesh.triangles.size())
                throw Failure(exit_mesh, source.name + " has changed since it was broken: open it again");
}

} // namespace

PiecesAs pieces_as(const std::string& word) {
    if (word == "made") return PiecesAs::made;
    if (word == "lie") return PiecesAs::they_lie;
    throw Failure(exit_usage, "'" + word + "' is not a pose for exported pieces; give lie or made");
}

Snapshot snapshot(const Simulation& simulation, std::shared_ptr<const fracture::Fragments> fragments) {
    Snapshot state{std::move(fragments), {}, {}};
    state.pieces = pieces_there(simulation, state.fragments->pieces.size());
    state.bonds = bonds_that_hold(simulation, state.pieces);
    return state;
}

LivePieces live_pieces(const Snapshot& state, const StagePlacement& placement) {
    return Builder(state, placement).build();
}

std::vector<std::filesystem::path> write_state(const ExportSettings& settings, PiecesAs as,
                                               const FractureOptions& recipe, const Input& source,
                                               const Snapshot& state, const std::function<bool()>& cancelled) {
    const StagePlacement placement = placement_on_stage(source.model.mesh, recipe.world, source.units);
    const LivePieces live = live_pieces(state, placement);
    check_source(live.fragments, source);
    fracture::ExportOptions options = export_options(settings, recipe, source);
    options.uv_by_plane = true;
    options.per_piece = splits_files(settings, live.fragments.pieces.size());
    if (as == PiecesAs::they_lie) options.poses = live.poses;
    std::vector<std::vector<fracture::TriangleMesh>> hulls;
    if (wants_hulls(settings)) {
        hulls = hulls_of(state, live.fragments, placement, hull_settings(settings), cancelled);
        options.hulls = hulls;
    }
    const fracture::Certificate certificate = fracture::certify(source.model.mesh, live.fragments);
    stop_if(cancelled);
    return must(fracture::export_pieces(settings.output, live.fragments, certificate, options));
}

std::vector<Snapshot> object_snapshots(const Simulation& simulation) {
    std::vector<Snapshot> states(simulation.members().size());
    for (Snapshot::Piece& piece : pieces_there(simulation, 0))
        states[simulation.member_of(piece.number)].pieces.push_back(std::move(piece));
    for (Snapshot& state : states) state.bonds = bonds_that_hold(simulation, state.pieces);
    return states;
}

size_t write_scene_state(const ExportSettings& settings, PiecesAs as, const LoadedScene& scene,
                         const Simulation& simulation) {
    const std::vector<Snapshot> states = object_snapshots(simulation);
    fracture::ObjectExport file;
    size_t pieces = 0;
    for (size_t k = 0; k < states.size(); ++k) {
        const LoadedObject& object = scene.objects[k];
        LivePieces live = live_pieces(states[k], {});
        if (as == PiecesAs::made)
            for (size_t p = 0; p < live.poses.size(); ++p)
                live.poses[p] = made_pose(object.placement, live.fragments.pieces[p].mass.centre_of_mass);
        fracture::ExportOptions options = export_options(settings, object.object.recipe, *object.input);
        options.images = object.images.get();
        options.name = object.object.name;
        options.uv_by_plane = true;
        options.poses = live.poses;
        options.fixed = object.object.fixed;
        std::vector<std::vector<fracture::TriangleMesh>> hulls;
        if (wants_hulls(settings) && !object.object.fixed) {
            hulls = hulls_of(states[k], live.fragments, {}, hull_settings(settings), {});
            options.hulls = hulls;
        }
        must(file.add(live.fragments, options));
        pieces += live.poses.size();
    }
    must(file.write(settings.output));
    return pieces;
}

fracture::PiecePose made_pose(const physics::Pose& placement, const glm::dvec3& centre_of_mass) {
    const glm::dquat turn = glm::normalize(glm::dquat(placement.orientation));
    return {glm::dvec3(placement.position) + turn * centre_of_mass, turn};
}

void check_export_of_scene(const FractureOptions& recipe, const ExportSettings& settings,
                           const std::string& output_option) {
    if (!is_scene(recipe)) return;
    if (!settings.stream.empty() && settings.stream != "glb")
        throw Failure(exit_usage, "--output-format: a scene is written as glb, not as " + settings.stream);
    if (settings.output.empty()) return;
    if (!settings.output.ends_with(".glb"))
        throw Failure(exit_usage, output_option + ": a scene is written as one .glb file, not as " + settings.output);
    if (settings.per_piece) throw Failure(exit_usage, "--per-piece: a scene is written as one file");
}

std::string written_text(size_t pieces, const std::vector<std::filesystem::path>& files) {
    std::string text = std::to_string(pieces) + (pieces == 1 ? " piece" : " pieces");
    if (!files.empty()) text += " in " + files.front().string();
    if (files.size() > 1) text += " and " + std::to_string(files.size() - 1) + " more";
    return text;
}

} // namespace brittle::tools
