#include "tools/brittle/stage/stage.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string_view>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/color_space.hpp>

#include "fracture/base/threads.h"
#include "physics/material.h"
#include "tools/brittle/base/device_failure.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

namespace {

constexpr float piece_tint_strength = 0.9f;
constexpr float material_tint_strength = 0.15f; // low, so that the material's own colour shows
constexpr float site_radius = 0.02f;            // m
// m, distance from the unbroken mesh beyond which pieces cast no shadow. With more room the texels of the shadow map
// are so coarse that shadows near the mesh have jagged edges and shadows of small pieces vanish.
constexpr float shadow_room = 4.0f;

uint32_t packed(const glm::vec3& linear) {
    const glm::uvec3 c(glm::convertLinearToSRGB(glm::clamp(linear, 0.0f, 1.0f)) * 255.0f + 0.5f);
    return engine::srgb8(c.x, c.y, c.z);
}

engine::Grain grain_of(std::string_view material) {
    constexpr std::pair<std::string_view, engine::Grain> grains[] = {
        {"glass", engine::Grain::glass}, {"stone", engine::Grain::stone},     {"concrete", engine::Grain::concrete},
        {"wood", engine::Grain::wood},   {"ceramic", engine::Grain::ceramic}, {"brick", engine::Grain::brick}};
    for (const auto& [name, grain] : grains)
        if (name == material) return grain;
    return engine::Grain::plain;
}

engine::SurfaceLook surface_look(const physics::MaterialPreset* material) {
    if (!material) return {.tint = piece_tint_strength};
    return {material->exterior, material->interior, material_tint_strength, grain_of(material->name)};
}

// The attributes of all exterior corners of a piece of a fracture.
std::vector<engine::CornerLook> corners_of(const fracture::Fragments& fragments, const fracture::Piece& piece,
                                           const MeshLooks& looks) {
    std::vector<engine::CornerLook> made;
    made.reserve(3 * size_t{piece.exterior_triangles});
    const auto positions = fragments.positions_of(piece);
    for (uint32_t t = 0; t < piece.exterior_triangles; ++t) {
        const fracture::Triangle& corner = fragments.triangles[piece.triangles.begin + t];
        const auto three = looks.corners(fragments.triangle_source[piece.triangles.begin + t],
                                         {positions[corner.x], positions[corner.y], positions[corner.z]});
        made.insert(made.end(), three.begin(), three.end());
    }
    return made;
}

// Returns whether any bond loses health under its load, or might once the stresses are in balance.
bool wears(const physics::Structure& structure) {
    if (!structure.wear().solver().converged()) return true;
    const auto bonds = structure.graph().bonds();
    const auto ratios = structure.wear().ratios();
    for (size_t k = 0; k < std::min(bonds.size(), ratios.size()); ++k)
        if (bonds[k].live() && ratios[k] >= bonds[k].health) return true;
    return false;
}

} // namespace

// The stage takes over the result when the piece appears.
DrawingMaker payload_maker(const engine::Renderer& renderer) {
    return [&renderer](const physics::SolidPiece& solid, const physics::SolidPiece* cut_from, const MeshLooks* looks) {
        auto drawing = draw_piece(solid, cut_from, looks);
        renderer.stage(drawing->batch);
        return drawing;
    };
}

engine::PieceBatch batch_of(const fracture::TriangleMesh& mesh, const MeshLooks* looks) {
    std::vector<engine::CornerLook> corners;
    for (uint32_t t = 0; looks && looks->of_mesh && t < mesh.triangles.size(); ++t) {
        const fracture::Triangle& corner = mesh.triangles[t];
        const auto three =
            looks->corners(t, {mesh.positions[corner.x], mesh.positions[corner.y], mesh.positions[corner.z]});
        corners.insert(corners.end(), three.begin(), three.end());
    }
    const std::vector<glm::vec3> positions(mesh.positions.begin(), mesh.positions.end());
    const engine::PieceMesh whole{.positions = positions,
                                  .triangles = mesh.triangles,
                                  .exterior_triangles = static_cast<uint32_t>(mesh.triangles.size()),
                                  .corners = corners};
    return must(engine::PieceBatch::create({&whole, 1}));
}

SceneMeshes meshes_of(const LoadedScene& scene) {
    SceneMeshes meshes;
    std::map<const Input*, uint32_t> known;
    std::vector<const Input*> originals;
    for (const LoadedObject& object : scene.objects) {
        const auto [at, is_new] = known.try_emplace(object.input.get(), static_cast<uint32_t>(originals.size()));
        if (is_new) originals.push_back(object.input.get());
        meshes.objects.push_back({at->second, object.placement, object.object.recipe.material, object.input->looks});
    }
    meshes.batches.resize(originals.size());
    fracture::Threads(scene.threads).for_each(static_cast<uint32_t>(originals.size()), [&](uint32_t k) {
        meshes.batches[k] = batch_of(originals[k]->model.mesh, originals[k]->looks.get());
    });
    return meshes;
}

PreparedPieces prepare_pieces(const engine::Renderer& renderer, const fracture::Fragments& fragments,
                              const WorldOptions& world, const std::string& material, uint32_t threads,
                              std::shared_ptr<const MeshLooks> looks) {
    PreparedPieces ahead;
    ahead.object = {.fragments = {std::shared_ptr<const fracture::Fragments>(), &fragments},
                    .world = world,
                    .material = material,
                    .looks = std::move(looks)};
    prepare(ahead.object, payload_maker(renderer), threads);
    ahead.object.fragments.reset();
    if (world.breakable) return ahead;
    std::vector<glm::vec3> positions(fragments.positions.size());
    std::vector<engine::PieceMesh> meshes;
    const MeshLooks* const drawn =
        ahead.object.looks && ahead.object.looks->of_mesh ? ahead.object.looks.get() : nullptr;
    std::vector<std::vector<engine::CornerLook>> corners(drawn ? fragments.pieces.size() : 0);
    for (const fracture::Piece& piece : fragments.pieces) {
        if (drawn) corners[meshes.size()] = corners_of(fragments, piece, *drawn);
        float radius = 0.0f;
        for (uint32_t v = piece.vertices.begin; v < piece.vertices.end; ++v) {
            positions[v] = glm::vec3(fragments.positions[v] - piece.mass.centre_of_mass);
            radius = std::max(radius, glm::length(positions[v]));
        }
        const auto body = static_cast<uint32_t>(meshes.size());
        ahead.radii.push_back(radius);
        meshes.push_back({.positions = std::span(positions).subspan(piece.vertices.begin, piece.vertices.size()),
                          .triangles = fragments.triangles_of(piece),
                          .exterior_triangles = piece.exterior_triangles,
                          .body = body,
                          .tint = engine::piece_tint(body),
                          .corners = drawn ? std::span<const engine::CornerLook>(corners[body])
                                           : std::span<const engine::CornerLook>(),
                          .centre = glm::vec3(piece.mass.centre_of_mass)});
    }
    ahead.batch = must(engine::PieceBatch::create(meshes));
    renderer.stage(ahead.batch);
    return ahead;
}

Stage::Stage(engine::Renderer& renderer, const fracture::TriangleMesh& mesh, const std::string& material,
             std::shared_ptr<const MeshLooks> looks)
    : Stage(renderer, fracture::bounds(mesh), batch_of(mesh, looks.get()), material, looks) {}

Stage::Stage(engine::Renderer& renderer, const fracture::Box& box, engine::PieceBatch whole,
             const std::string& material, std::shared_ptr<const MeshLooks> looks)
    : renderer_(renderer),
      simulation_(material, payload_maker(renderer)), home_{glm::vec3(box.min), glm::vec3(box.max)} {
    use_looks({std::move(looks)});
    draw_anew(std::move(whole));
}

// Passes the materials of meshes to the renderer, those of equal meshes once.
void Stage::use_looks(std::vector<std::shared_ptr<const MeshLooks>> looks) {
    std::vector<std::shared_ptr<const engine::MaterialSet>> sets;
    std::vector<uint32_t> first; // by set: the materials before its own
    uint32_t materials = 0;
    first_materials_.clear();
    has_materials_ = false;
    for (const auto& one : looks) {
        first_materials_.push_back(0);
        if (!one) continue;
        has_materials_ = has_materials_ || one->of_mesh;
        const auto at = static_cast<size_t>(std::ranges::find(sets, one->materials) - sets.begin());
        if (at == sets.size()) {
            sets.push_back(one->materials);
            first.push_back(materials);
            materials += static_cast<uint32_t>(one->materials->materials.size());
        }
        first_materials_.back() = first[at];
    }
    looks_ = std::move(looks);
    must(renderer_.set_materials(std::move(sets)));
}

void Stage::stand(const fracture::Fragments& fragments, const WorldOptions& world) {
    const physics::MaterialPreset* material = simulation_.material();
    stand(fragments, world,
          prepare_pieces(renderer_, fragments, world, std::string(material ? material->name : ""), 0, looks_.front()));
}

void Stage::stand(const fracture::Fragments& fragments, const WorldOptions& world, PreparedPieces ahead) {
    ahead.object.fragments = {std::shared_ptr<const fracture::Fragments>(), &fragments};
    simulation_.start(std::move(ahead.object));
    draw_anew(std::move(ahead.batch));
    radii_ = std::move(ahead.radii);
    surfaces_.clear();
    surface_of_.clear();
    untinted_ = starts_whole(world);
    max_pieces_ = world.piece_limit;
    passed_watch_.reset();
    start_particles();
    take_events();
}

void Stage::stand(std::vector<PreparedObject> objects, const WorldOptions& world) {
    std::vector<std::shared_ptr<const MeshLooks>> looks;
    for (const PreparedObject& object : objects) looks.push_back(object.looks);
    use_looks(std::move(looks));
    simulation_.start(std::move(objects), world);
    draw_anew({});
    radii_.clear();
    members_.clear();
    carried_.clear();
    untinted_ = true;
    max_pieces_ = world.piece_limit;
    passed_watch_.reset();
    std::vector<const physics::MaterialPreset*> materials;
    for (const Simulation::Member& member : simulation_.members()) materials.push_back(member.material);
    choose_surfaces(materials);
    start_particles();
    take_events();
}

void Stage::show(const SceneMeshes& meshes) {
    draw_anew({});
    carried_.clear();
    std::vector<std::shared_ptr<const MeshLooks>> looks;
    std::vector<const physics::MaterialPreset*> materials;
    for (const SceneMeshes::Object& object : meshes.objects) {
        looks.push_back(object.looks);
        materials.push_back(physics::material_preset(object.material));
    }
    use_looks(std::move(looks));
    choose_surfaces(materials);
    radii_.clear();
    members_.clear();
    std::vector<std::optional<engine::PieceHandle>> originals(meshes.batches.size());
    for (uint32_t k = 0; k < meshes.objects.size(); ++k) {
        const SceneMeshes::Object& object = meshes.objects[k];
        engine::PieceBatch batch = meshes.batches[object.batch];
        const glm::vec4 sphere = batch.pieces().front().sphere;
        const glm::vec3 centre(sphere);
        const engine::PieceAttachment attachment{.body = k,
                                                 .offset = -centre,
                                                 .id = k + 1,
                                                 .surface = surface_of_[k],
                                                 .centre = centre,
                                                 .first_material = first_materials_[k]};
        std::optional<engine::PieceHandle>& original = originals[object.batch];
        engine::PieceHandle handle;
        if (original) {
            handle = must(renderer_.copy_pieces({&*original, 1}, attachment)).front();
        } else {
            batch.attach(attachment);
            handle = must(renderer_.add_pieces(std::move(batch))).front();
            original = handle;
        }
        const physics::Pose& at = object.placement;
        meshes_.push_back({handle, {at.position + at.orientation * centre, at.orientation}});
        radii_.push_back(sphere.w);
        members_.push_back(k);
    }
    std::vector<bool> hidden;
    std::swap(hidden, hidden_);
    hide(std::move(hidden));
}

// A surface for each material of the objects; 0 for that which the look of the scene has.
void Stage::choose_surfaces(std::span<const physics::MaterialPreset* const> materials) {
    surfaces_.clear();
    surface_of_.clear();
    std::vector<const physics::MaterialPreset*> known{simulation_.material()};
    for (const physics::MaterialPreset* const material : materials) {
        const auto at = std::ranges::find(known, material);
        surface_of_.push_back(static_cast<uint32_t>(at - known.begin()));
        if (at != known.end()) continue;
        known.push_back(material);
        surfaces_.push_back(surface_look(material));
    }
}

void Stage::start_particles() {
    std::vector<ParticleLook> looks;
    for (const Simulation::Member& member : simulation_.members())
        looks.push_back(particle_look(member.material, surface_look(member.material)));
    particles_.start(simulation_, std::move(looks));
}

void Stage::shoot(const Shot& shot) {
    if (broken()) simulation_.apply(Shoot{shot.from, shot.velocity, shot.radius, shot.density});
}

// Replaces all drawn geometry, and starts a new run.
void Stage::draw_anew(engine::PieceBatch batch) {
    alpha_ = 1.0f;
    drawn_.clear();
    meshes_.clear();
    (void)must(renderer_.set_pieces({}));
    (void)must(renderer_.add_pieces(std::move(batch)));
    moment_before_ = moment_ + 1;
    all_moved_ = moment_before_;
    last_awake_ = 0;
    moved_ = true;
}

// Returns the tint of a new piece. The largest part of a cut piece keeps its tint, so that a statue that loses an arm
// does not change its colour.
glm::vec3 Stage::tint_of(const physics::PieceAdded& added, std::span<const physics::PieceAdded> all,
                         const std::map<physics::PieceId, glm::vec3>& before) const {
    const auto volume = [](const physics::PieceAdded& piece) { return piece.solid->mass.volume; };
    const bool largest = std::ranges::none_of(all, [&](const physics::PieceAdded& other) {
        return other.parent == added.parent && volume(other) > volume(added);
    });
    if (const auto old = before.find(added.parent); old != before.end() && largest) return old->second;
    return added.depth == 0 && untinted_ ? glm::vec3(1.0f) : engine::piece_tint(added.id.value);
}

engine::PieceAttachment Stage::attachment_for(const physics::PieceAdded& added) const {
    const glm::vec3& tint = drawn_.at(added.id).tint;
    engine::PieceAttachment attachment = attachment_of(*added.solid, added.slot, tint, added.id);
    const uint32_t member = simulation_.member_of(added.object);
    if (!surface_of_.empty()) attachment.surface = surface_of_[member];
    attachment.first_material = first_materials_[member];
    return attachment;
}

// Attaches the parts of removed pieces that a new piece keeps, and adds the new parts to `fresh`. A part that no removed
// piece has, because its piece came and went between two calls, is drawn here.
void Stage::draw(const physics::PieceAdded& added, PieceDrawing& drawing, PartPool& left, FreshParts& fresh) {
    const engine::PieceAttachment attachment = attachment_for(added);
    Drawn& drawn = drawn_.at(added.id);
    std::vector<engine::PieceHandle> kept;
    std::vector<fracture::ClusterBranch> missing;
    for (const fracture::ClusterBranch& branch : drawing.kept) {
        if (const auto part = left.extract({added.object, branch.key()})) {
            kept.push_back(part.mapped().handle);
            drawn.parts.push_back(part.mapped());
        } else {
            missing.push_back(branch);
        }
    }
    must(renderer_.attach_pieces(kept, attachment));
    const auto add = [&](engine::PieceBatch batch, std::span<const fracture::ClusterBranch> branches) {
        batch.attach(attachment);
        for (size_t k = 0; k < batch.pieces().size(); ++k)
            fresh.owners.emplace_back(added.id, branches.empty() ? std::nullopt : std::optional(branches[k]));
        fresh.batches.push_back(std::move(batch));
    };
    const MeshLooks* const looks = looks_[simulation_.member_of(added.object)].get();
    if (!missing.empty()) add(draw_branches(*added.solid, missing, looks), missing);
    add(std::move(drawing.batch), drawing.made);
}

// Draws a new piece. One without a payload is a copy (copy_of() in prepared_object.h): it has the geometry of a piece of
// the same solid, if there is one.
void Stage::draw(physics::PieceAdded& added, PartPool& left, FreshParts& fresh, Alike& alike) {
    if (!added.payload && alike.originals.contains(added.solid.get())) {
        alike.copies.push_back(&added);
        return;
    }
    if (!added.payload)
        added.payload = draw_piece(*added.solid, nullptr, looks_[simulation_.member_of(added.object)].get());
    if (added.parent == physics::PieceId{}) alike.originals.emplace(added.solid.get(), added.id);
    auto& drawing = static_cast<PieceDrawing&>(*added.payload);
    draw(added, drawing, left, fresh);
    particles_.cut(simulation_, added, drawing.cracks);
}

void Stage::draw_copies(const Alike& alike) {
    for (const physics::PieceAdded* const added : alike.copies) {
        const std::vector<Part>& parts = drawn_.at(alike.originals.at(added->solid.get())).parts;
        std::vector<engine::PieceHandle> handles;
        for (const Part& part : parts) handles.push_back(part.handle);
        const std::vector<engine::PieceHandle> copies = must(renderer_.copy_pieces(handles, attachment_for(*added)));
        for (size_t k = 0; k < copies.size(); ++k) show(drawn_.at(added->id), parts[k].branch, copies[k]);
    }
}

// Notes a part that the renderer draws for a piece.
void Stage::show(Drawn& drawn, const std::optional<fracture::ClusterBranch>& branch, engine::PieceHandle handle) {
    drawn.parts.push_back({branch, handle});
    if (is_hidden(drawn.object)) must(renderer_.fade_pieces({&handle, 1}, 1.0f));
}

// Draws the pieces that appeared, and removes the pieces that disappeared, since the last call. Removal comes first,
// because new pieces reuse slots.
void Stage::take_events() {
    physics::DestructionEvents events = simulation_.take_events();
    std::vector<engine::PieceHandle> gone;
    PartPool left; // parts of removed pieces that new pieces may keep
    std::map<physics::PieceId, glm::vec3> before;
    for (const physics::PieceRemoved& removed : events.removed) {
        const auto at = drawn_.find(removed.id);
        before[removed.id] = at->second.tint;
        for (const Part& part : at->second.parts) {
            if (part.branch)
                left.emplace(std::pair(at->second.object, part.branch->key()), part);
            else
                gone.push_back(part.handle);
        }
        drawn_.erase(at);
    }
    FreshParts fresh;
    Alike alike;
    for (physics::PieceAdded& added : events.added) {
        drawn_[added.id] = {{}, tint_of(added, events.added, before), added.object};
        draw(added, left, fresh, alike);
        radii_.resize(std::max<size_t>(radii_.size(), added.slot + size_t{1}), 0.0f);
        radii_[added.slot] = added.solid->radius;
        members_.resize(radii_.size(), 0);
        members_[added.slot] = simulation_.member_of(added.object);
    }
    for (const auto& [key, part] : left) gone.push_back(part.handle);
    must(renderer_.remove_pieces(gone));
    const std::vector<engine::PieceHandle> handles = must(renderer_.add_pieces(std::move(fresh.batches)));
    for (size_t k = 0; k < handles.size(); ++k) {
        const auto& [piece, branch] = fresh.owners[k];
        show(drawn_.at(piece), branch, handles[k]);
    }
    draw_copies(alike);
    for (const physics::PieceFading& fading : events.fading) {
        std::vector<engine::PieceHandle> parts;
        for (const Part& part : drawn_.at(fading.id).parts) parts.push_back(part.handle);
        must(renderer_.fade_pieces(parts, 1.0f - fading.share));
    }
}

void Stage::watch(const engine::Camera& camera, float aspect) {
    watch_ = {.eye = camera.eye, .target = camera.target, .fov = double{camera.vertical_fov}, .aspect = double{aspect}};
}

// Passes the view to a breakable simulation, where it decides which debris is removed. The view of exploded pieces is
// converted into the equivalent view of the pieces in place.
void Stage::pass_view() {
    if (!watch_ || !simulation_.destruction()) return;
    const glm::dvec3 centre(home_.centre());
    const double apart = 1.0 + double{explode_};
    Watch now = *watch_;
    for (glm::dvec3* at : {&now.eye, &now.target}) *at = centre + (*at - centre) / apart;
    if (now == passed_watch_ || !fault_of(now, 0).empty()) return;
    simulation_.apply(now);
    passed_watch_ = now;
}

void Stage::advance(double seconds) {
    if (!broken()) return;
    pass_view();
    alpha_ = simulation_.advance(seconds);
    particles_.advance(simulation_);
    take_events();
    if (!particles_.empty()) moved_ = true;
    // A body that falls asleep reaches its last pose one step later.
    if (world().awake_count() > 0) last_awake_ = simulation_.steps();
    if (simulation_.steps() <= last_awake_ + 2) moved_ = true;
}

bool Stage::still() const {
    if (!broken()) return true;
    const physics::Destruction* destruction = simulation_.destruction();
    if (destruction && (destruction->jobs_in_flight() > 0 || destruction->pieces().size() > max_pieces_)) return false;
    for (const physics::Structure* structure : simulation_.structures())
        if (wears(*structure)) return false;
    return particles_.empty() && simulation_.steps() > last_awake_ + 2;
}

void Stage::show_sites(std::span<const glm::dvec3> sites) {
    spheres_.clear();
    for (const glm::dvec3& s : sites) spheres_.push_back({.centre = glm::vec3(s), .radius = site_radius});
}

void Stage::explode(float share) {
    if (share == explode_) return;
    explode_ = share;
    draw_all_poses();
}

void Stage::carry(std::vector<physics::Pose> moves) {
    carried_ = std::move(moves);
    draw_all_poses();
}

void Stage::hide(std::vector<bool> hidden) {
    if (hidden == hidden_) return;
    std::vector<engine::PieceHandle> out, in;
    std::swap(hidden, hidden_);
    for (const auto& [piece, drawn] : drawn_)
        for (const Part& part : drawn.parts) (is_hidden(drawn.object) ? out : in).push_back(part.handle);
    for (uint32_t k = 0; k < meshes_.size(); ++k) (is_hidden(k) ? out : in).push_back(meshes_[k].handle);
    must(renderer_.fade_pieces(out, 1.0f));
    must(renderer_.fade_pieces(in, 0.0f));
    moved_ = true;
}

bool Stage::is_hidden(physics::ObjectId object) const {
    return !hidden_.empty() && is_hidden(simulation_.member_of(object));
}

bool Stage::is_hidden(uint32_t object) const {
    return object < hidden_.size() && hidden_[object];
}

// A separate moment, at which every pose changes.
void Stage::draw_all_poses() {
    ++moment_before_;
    all_moved_ = moment_before_ + simulation_.steps();
    moved_ = true;
}

physics::Pose Stage::drawn_pose(uint32_t slot, const physics::Pose& pose) const {
    physics::Pose at = pose;
    if (slot < members_.size() && members_[slot] < carried_.size()) {
        const physics::Pose& by = carried_[members_[slot]];
        at = {by.position + by.orientation * pose.position, glm::normalize(by.orientation * pose.orientation)};
    }
    at.position += explode_ * (at.position - home_.centre());
    return at;
}

// Calls visit(slot, pose) for what moved in a step from `since` on. Meshes without bodies move by carry() alone.
template<class Visit>
void Stage::visit_poses(uint64_t since, const Visit& visit) const {
    for (uint32_t slot = 0; slot < meshes_.size(); ++slot) visit(slot, meshes_[slot].pose);
    if (broken()) simulation_.visit_poses(alpha_, since, visit);
}

// Sets the bounds of all shadow casters, and the function that writes the poses that changed since the slice of the
// instance buffer was written.
void Stage::place(engine::Scene& scene) {
    engine::Bounds room{home_.min - shadow_room, home_.max + shadow_room};
    room.min.y = std::min(room.min.y, 0.0f); // down to the ground
    scene.bounds = {room.max, room.min};
    const auto include = [&](const glm::vec3& centre, float radius) {
        if (glm::clamp(centre, room.min, room.max) == centre)
            scene.bounds = engine::join(scene.bounds, {centre - radius, centre + radius});
    };
    visit_poses(
        0, [&](uint32_t slot, const physics::Pose& pose) { include(drawn_pose(slot, pose).position, radii_[slot]); });
    if (!simulation_.balls().empty())
        for (const engine::Sphere& sphere : shown_spheres_) include(sphere.centre, sphere.radius);
    if (scene.bounds.min.x > scene.bounds.max.x) scene.bounds = home_; // no piece is inside the room
    moment_ = moment_before_ + simulation_.steps();
    scene.moment = moment_;
    scene.write_poses = [this](std::span<engine::BodyPose> out, uint64_t since) {
        const uint64_t steps = since < all_moved_ ? 0 : since - moment_before_;
        visit_poses(steps, [&](uint32_t slot, const physics::Pose& pose) {
            const physics::Pose at = drawn_pose(slot, pose);
            if (slot < out.size()) out[slot] = {.rotation = at.orientation, .position = at.position};
        });
    };
}

// The exploded view moves particles as it moves pieces.
void Stage::place_particles(engine::Scene& scene) {
    splinters_.clear();
    dust_.clear();
    particles_.draw(alpha_, splinters_, dust_);
    const auto move_apart = [&](glm::vec3& at) { at += explode_ * (at - home_.centre()); };
    for (engine::Splinter& one : splinters_) move_apart(one.centre);
    for (engine::DustPuff& one : dust_) move_apart(one.centre);
    scene.splinters = splinters_;
    scene.dust = dust_;
}

engine::Scene Stage::scene() {
    engine::Scene scene;
    scene.bounds = home_;
    const engine::SurfaceLook look = surface_look(simulation_.material());
    scene.look.exterior = look.exterior;
    scene.look.interior = look.interior;
    scene.look.tint = look.tint;
    scene.look.grain = look.grain;
    scene.materials = shows_materials();
    scene.surfaces = surfaces_;
    shown_spheres_ = spheres_;
    for (const Simulation::Ball& ball : simulation_.balls()) {
        shown_spheres_.push_back({world().interpolated_pose(ball.body, alpha_).position, ball.radius});
    }
    scene.spheres = shown_spheres_;
    scene.spheres_on_top = simulation_.balls().empty();
    scene.spheres_cast_shadows = !scene.spheres_on_top;
    if (broken() || !meshes_.empty()) place(scene);
    place_particles(scene);
    lines_ = own_lines_;
    if (hulls_) {
        debug_lines_.clear();
        world().debug_lines(debug_lines_);
        for (const physics::DebugLine& line : debug_lines_) {
            lines_.push_back({line.from, packed(line.colour)});
            lines_.push_back({line.to, packed(line.colour)});
        }
    }
    scene.lines = lines_;
    scene.lines_on_top = true;
    scene.moved = moved_;
    moved_ = false;
    return scene;
}

} // namespace brittle::tools
