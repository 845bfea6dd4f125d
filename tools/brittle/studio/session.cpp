#include "tools/brittle/studio/session.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <utility>

#include <glm/geometric.hpp>

#include "physics/world/world.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/recipe.h"

namespace brittle::tools {

namespace {

constexpr float preview_tint = 0.8f;
constexpr float tint_of_the_struck = 0.12f;
const double physics_step = physics::WorldSettings{}.step; // s; 1/120 as a double would be a little less
constexpr float hull_lift = 0.01f; // share of the way to the eye by which lines of hulls are drawn before pieces
constexpr float far_away = 12.0f;  // m from the middle, where the stage's shadow ends

bool same_sites(const FractureOptions& a, const FractureOptions& b) {
    const auto how = [](const FractureOptions& options) {
        FractureOptions only;
        only.pattern = options.pattern;
        only.sites_file = options.sites_file;
        only.points = options.points;
        only.fit_sites = options.fit_sites;
        only.sites_placement = options.sites_placement;
        only.min_volume = options.min_volume;
        only.rough = options.rough;
        only.algorithm = options.algorithm;
        return recipe_json(only);
    };
    return how(a) == how(b);
}

// The colour of a bond by its load: grey without load, through yellow, to red at the limit.
uint32_t bond_colour(double load) {
    const double up = std::min(1.0, 2.0 * load), down = std::max(0.0, 2.0 * load - 1.0);
    return engine::srgb8(static_cast<uint32_t>(100 + 150 * up), static_cast<uint32_t>(122 + 78 * up - 160 * down),
                         static_cast<uint32_t>(112 - 60 * up));
}

// Equal for recipes of equal meshes, or of equal objects.
std::string subject_of(const FractureOptions& options) {
    FractureOptions only;
    only.mesh = options.mesh;
    only.repair = options.repair;
    only.unite = options.unite;
    only.units = options.units;
    only.piece_scale = options.piece_scale;
    only.objects = options.objects;
    only.glue = options.glue;
    return recipe_json(only);
}

bool same_strikes(const FractureOptions& a, const FractureOptions& b) {
    return std::equal(a.strikes.begin(), a.strikes.end(), b.strikes.begin(), b.strikes.end());
}

} // namespace

Session::Session(FractureOptions recipe, std::shared_ptr<const Object> object, engine::Renderer& renderer,
                 fracture::Classifier* classifier)
    : document_(std::move(recipe)), object_(std::move(object)), renderer_(renderer), classifier_(classifier) {
    recorder_.emplace(document_.recipe());
    make_stage();
    sites_.generate(document_.recipe(), *object_);
    object_->is_prepared() ? tell_notes() : read_object();
}

Session::~Session() {
    activity_.cancel();
}

// Forgets the selected piece and all previews.
void Session::leave_piece() {
    preview_.forget();
    piece.reset();
}

// `parts`: those of a scene with their payloads, made ahead; or empty.
void Session::make_stage(std::vector<PreparedObject> parts) {
    stage_ = std::make_unique<Stage>(renderer_, object_->home(), object_->batch(), recipe().material, object_->looks());
    stage_->simulation().commit_as(physics::Timing::when_ready);
    stage_->simulation().observe(&*recorder_);
    ++stages_;
    moved_ = false;
    watched_shot_.reset();
    shot_.reset(); // the ball and the blow that wait for the pieces of the old stage
    blow_.reset();
    playing_ = false;
    leave_piece();
    if (!object_->is_scene()) return;
    if (object_->is_prepared())
        stand_scene(parts.empty() ? parts_of(*object_, renderer_, recipe().threads) : std::move(parts));
    else
        show_scene();
}

std::string Session::name() const {
    return object_->is_scene() && !recipe_file.empty() ? std::filesystem::path(recipe_file).stem().string()
                                                       : object_->name();
}

uint32_t Session::blow_pieces(uint32_t of) const {
    if (!object_->is_scene()) return recipe().world.blow_pieces;
    return object_->scene().objects[stage_->simulation().member_of(of)].object.recipe.world.blow_pieces;
}

// --- the recipe ---

void Session::edit(const Edit& edit, uint64_t gesture) {
    const FractureOptions before = recipe();
    try {
        if (document_.apply(edit, gesture)) follow(before);
    } catch (const Failure& failure) {
        report(failure);
    }
}

void Session::undo() {
    const FractureOptions before = recipe();
    if (document_.undo()) follow(before);
}

void Session::redo() {
    const FractureOptions before = recipe();
    if (document_.redo()) follow(before);
}

// Brings the stage up to date with the recipe.
void Session::follow(const FractureOptions& before) {
    const FractureOptions& now = recipe();
    std::erase_if(selected, [&](uint32_t k) { return k >= now.objects.size(); });
    if (subject_of(now) != subject_of(before)) {
        if (!follow_places()) read_object();
        return;
    }
    if (object_->is_scene()) {
        make_stage();
        return;
    }
    const bool placed = now.world.anchored != before.world.anchored || now.world.height != before.world.height;
    const bool sites = !same_sites(now, before), strikes = !same_strikes(now, before);
    const bool anchors = now.world.anchors != before.world.anchors;
    if (placed) object_ = object_->placed_for(now.world);
    if (placed || now.material != before.material || ((sites || strikes || anchors) && (broken() || activity_.busy())))
        make_stage();
    if (placed || sites || strikes) {
        try {
            sites_.generate(now, *object_);
            if (!sites && !placed) return;
            activity_.say({});
        } catch (const Failure& failure) {
            report(failure);
        }
        std::erase_if(sites_.selection, [this](uint32_t s) { return s >= sites_.on_stage().size(); });
    }
}

// Reads and prepares the mesh or the scene of the recipe on the worker. While the mouse holds a control, results come
// slower than changes, so one that is older than the recipe is shown, too.
void Session::read_object() {
    const auto read = [this, number = ++reads_, now = recipe(), before = object_](const Worker::Cancelled& cancelled) {
        try {
            auto object = Object::load(
                now, [this](double share) { activity_.set_share(share); }, before.get(), cancelled);
            auto parts = std::make_shared<std::vector<PreparedObject>>(parts_of(*object, renderer_, now.threads));
            activity_.post([this, object, parts, number, subject = subject_of(now)] {
                if (number < valid_reads_) return;
                valid_reads_ = number + 1;
                const bool is_new = subject_of(recipe()) == subject;
                if (is_new || (preview_.held && object->is_scene() && object_->is_scene()))
                    adopt(object, std::move(*parts));
            });
        } catch (const Failure& failure) {
            activity_.post([this, failure, number] {
                if (number < valid_reads_) return;
                valid_reads_ = number + 1;
                report(failure);
            });
        }
    };
    activity_.start(is_scene(recipe()) ? "preparing the scene" : "reading " + recipe().mesh, read);
}

void Session::adopt(std::shared_ptr<const Object> object, std::vector<PreparedObject> parts) {
    const std::shared_ptr<const Object> before = std::exchange(object_, std::move(object));
    sites_.selection.clear();
    counts_.reset();
    activity_.say({});
    make_stage(std::move(parts));
    try {
        sites_.generate(recipe(), *object_);
    } catch (const Failure& failure) {
        report(failure);
    }
    if (!object_->is_scene() && files_.opened) files_.opened(recipe().mesh);
    if (!object_->is_prepared()) return read_object();
    const bool told = object_->is_scene() && before->is_scene() && before->is_prepared()
                      && before->scene().notes == object_->scene().notes;
    if (!told) tell_notes();
    if (object_->is_scene()) lay_down();
    if (const auto due = std::exchange(due_, {}); due && object_->is_scene()) due();
}

void Session::take_sites(uint64_t gesture) {
    if (!recipe().points.empty()) return;
    edit(SetSites{sites_.placed()}, gesture);
}

Anchor Session::anchor_at(const glm::dvec3& on_stage) const {
    return {on_stage - glm::dvec3(0.0, foot_height(recipe().world), 0.0), double{tools.brush_radius}};
}

glm::dvec3 Session::on_stage(const Anchor& anchor) const {
    return anchor.at + glm::dvec3(0.0, foot_height(recipe().world), 0.0);
}

// --- the stage ---

PieceView Session::pieces() const {
    static const fracture::Fragments none;
    return {stage_->simulation(), broken() && fragments_ ? *fragments_ : none, radii_, poses_};
}

engine::Bounds Session::all_bounds() const {
    const PieceView all = pieces();
    engine::Bounds joined{glm::vec3(far_away), glm::vec3(-far_away)};
    for (const uint32_t number : all.numbers()) {
        const engine::Bounds bounds = all.bounds(number).value_or(stage_->home_bounds());
        if (glm::length(bounds.centre()) < far_away) joined = engine::join(joined, bounds);
    }
    return joined.min.x <= joined.max.x ? joined : stage_->home_bounds();
}

void Session::break_all() {
    if (object_->is_scene()) {
        if (!stand_now()) return once_it_stands("time begins", [this] { break_all(); });
        playing_ = true;
        return;
    }
    if (!recipe().strikes.empty()) edit(ClearStrikes{});
    if (broken() || activity_.busy()) return;
    WorldOptions world = recipe().world;
    if (starts_whole(world)) { // cut the whole mesh at its place and let the pieces fall
        world.height = foot_height(world);
        world.breakable = world.anchored = false;
        world.anchors.clear();
    }
    start_breaking(world);
}

void Session::strike_along(const glm::dvec3& from, const glm::dvec3& direction) {
    if (!stand_now()) return once_it_stands("the blow falls", [=, this] { strike_along(from, direction); });
    if (!broken()) {
        if (const auto hit = object_->first_hit(from, direction)) strike(hit->point, direction);
    } else if (const auto hit = first_piece(from, direction)) {
        strike(*hit, direction);
    }
}

void Session::strike(const glm::dvec3& at, const glm::dvec3& direction) {
    if (activity_.busy()) return;
    WorldOptions world = recipe().world;
    if (world.breakable) {
        blow_ = blow_at(tools, at, direction);
    } else {
        edit(AddStrike{strike_at(tools, *object_, at, direction)});
        world.bonded = holds_together(world);
    }
    start_breaking(world);
}

void Session::strike(const PieceHit& hit, const glm::dvec3& direction) {
    if (!stand_now() || !pieces().contains(hit.piece)) return;
    if (stage_->simulation().destruction()) {
        Simulation& simulation = stage_->simulation();
        if (const Simulation::Member& member = simulation.members()[simulation.member_of(hit.piece)]; member.fixed) {
            activity_.say({member.name + " is fixed, and never breaks."});
            return;
        }
        simulation.apply(hammer_blow(simulation, hit, direction, double{tools.hammer_radius}, blow_pieces(hit.piece)));
        playing_ = true;
    } else { // at the place of the point in the whole mesh
        strike(glm::dvec3(hit.grip) + fragments_->pieces[hit.piece].mass.centre_of_mass, direction);
    }
}

void Session::shoot(const glm::vec3& from, const glm::vec3& direction) {
    if (!stand_now()) return once_it_stands("the ball flies", [=, this] { shoot(from, direction); });
    if (broken()) {
        stage_->shoot({.from = glm::dvec3(from),
                       .velocity = glm::dvec3(tools.ball_speed * direction),
                       .radius = tools.ball_radius});
        playing_ = true;
        if (const physics::Destruction* destruction = stage_->simulation().destruction())
            watched_shot_ =
                WatchedShot{steps(), destruction->statistics().breaks + destruction->statistics().overloads};
        return;
    }
    if (activity_.busy()) return;
    shot_ = {from, direction};
    WorldOptions world = recipe().world;
    world.bonded = world.bonded || !world.breakable;
    start_breaking(world);
}

void Session::grab(const PieceHit& hit) {
    if (!stand_now()) return;
    stage_->simulation().apply(Grab{hit.piece, place_of(stage_->simulation(), hit)});
    playing_ = true;
}

void Session::drag(const glm::vec3& to) {
    stage_->simulation().apply(Drag{glm::dvec3(to)});
}

void Session::let_go() {
    stage_->simulation().apply(LetGo{});
}

void Session::reset() {
    due_ = {};
    picture().explode = 0.0f;
    if (!object_->is_scene()) activity_.cancel(); // a scene that is being read is awaited
    if (!recipe().strikes.empty()) edit(ClearStrikes{});
    counts_.reset();
    activity_.say({});
    make_stage();
}

void Session::start_breaking(const WorldOptions& world) {
    FractureOptions options = recipe();
    options.world = world;
    activity_.start("breaking " + object_->name(), [this, object = object_, options,
                                                    stage = stages_](const Worker::Cancelled& cancelled) {
        const WorldOptions stands = world_of(options, object->scale());
        const Input input = object->with_sites(options);
        auto made = std::make_shared<Broken>(break_input(
            input, options, [this](double share) { activity_.set_share(share); }, classifier_, cancelled));
        auto ahead = std::make_shared<PreparedPieces>(
            prepare_pieces(renderer_, made->fragments, stands, options.material, 0, object->looks()));
        activity_.post([this, made, ahead, stands, stage] {
            if (stages_ == stage) take_pieces(std::move(*made), std::move(*ahead), stands);
        });
    });
}

void Session::take_pieces(Broken made, PreparedPieces ahead, const WorldOptions& world) {
    leave_piece();
    recorder_->use_recipe(recipe());
    stage_->stand(made.fragments, world, std::move(ahead));
    playing_ = true;
    world_ = world;
    counts_ = {made.certificate.pieces, 0, made.milliseconds, made.certificate, made.fragments.timings};
    fragments_ = std::make_shared<const fracture::Fragments>(std::move(made.fragments));
    radii_.clear();
    for (const fracture::Piece& p : fragments_->pieces) {
        double radius = 0.0;
        for (const glm::dvec3& v : fragments_->positions_of(p))
            radius = std::max(radius, glm::distance(v, p.mass.centre_of_mass));
        radii_.push_back(static_cast<float>(radius));
    }
    poses_.assign(radii_.size(), {});
    for (size_t k = 0; k < poses_.size(); ++k)
        poses_[k].position = glm::vec3(fragments_->pieces[k].mass.centre_of_mass);
    fractured_ = true;
    activity_.say({});
    if (const auto shot = std::exchange(shot_, std::nullopt)) shoot((*shot)[0], (*shot)[1]);
    if (const auto at = std::exchange(blow_, std::nullopt))
        if (const auto hammer = hammer_at(stage_->simulation(), *fragments_, *at, recipe().world.blow_pieces))
            stage_->simulation().apply(*hammer);
}

void Session::step_once() {
    if (!stand_now()) return once_it_stands("time begins", [this] { step_once(); });
    playback.paused = true;
    single_step_ = true;
    playing_ = broken();
}

void Session::report(const Failure& failure, const std::string& mend) {
    shot_.reset();
    due_ = {};
    lay_down_.reset();
    if (failure.code() == exit_environment) throw failure; // the device is gone
    if (failure.code() == exit_interrupted)
        activity_.say({"cancelled"});
    else
        activity_.say({failure.what(), true, mend});
}

// --- each frame ---

void Session::watch(const engine::Camera& camera, float aspect) {
    camera_ = camera;
    stage_->watch(camera, aspect);
}

void Session::update(double seconds) {
    activity_.deliver();
    if (moved_ && !preview_.held && !reads()) read_object();
    preview_.update();
    if (!playing_) return;
    if (std::exchange(single_step_, false)) {
        stage_->advance(physics_step);
    } else if (!playback.paused) {
        stage_->advance(seconds * playback.speed);
    }
    if (counts_) counts_->awake = stage_->world().awake_count();
    if (const physics::Destruction* destruction = stage_->simulation().destruction(); destruction && counts_)
        counts_->pieces = static_cast<uint32_t>(destruction->pieces().size());
    tell_borne_shot();
    if (piece && !pieces().contains(*piece)) piece.reset(); // it was cut
}

// Says why a ball broke nothing: its hardest blow, and the energy that would break what it hit.
void Session::tell_borne_shot() {
    constexpr uint64_t patience = 30; // steps, for what breaks late
    const Simulation& simulation = stage_->simulation();
    if (!watched_shot_ || !simulation.destruction()) return;
    const physics::Destruction& destruction = *simulation.destruction();
    const auto is_ball = [&](physics::BodyId body) {
        return std::ranges::find(simulation.balls(), body, &Simulation::Ball::body) != simulation.balls().end();
    };
    std::optional<physics::BorneBlow>& borne = watched_shot_->borne;
    for (const physics::BorneBlow& blow : destruction.borne())
        if (blow.step > watched_shot_->step && is_ball(blow.striker)
            && (!borne || blow.blow.energy > borne->blow.energy))
            borne = blow;
    const auto cuts = destruction.statistics().breaks + destruction.statistics().overloads;
    if (cuts != watched_shot_->cuts) {
        watched_shot_.reset();
        return;
    }
    if (!borne || steps() < borne->step + patience || destruction.jobs_in_flight() > 0) return;
    const physics::BorneBlow blow = *borne;
    watched_shot_.reset();
    if (!destruction.contains(blow.piece)) return;
    const std::string name = simulation.members()[simulation.member_of(blow.piece.value)].name;
    const double energy = blow.blow.energy;
    const double needed =
        physics::breaking_energy(blow.blow, blow.bounce / energy, blow.material, blow.volume, blow.limits);
    char text[200];
    if (needed > energy && std::isfinite(needed))
        std::snprintf(text, sizeof text, "hit with %.3g J, and breaks from about %.3g J on", energy, needed);
    else
        std::snprintf(text, sizeof text, "hit with %.3g J; what that takes off is below its smallest pieces", energy);
    activity_.say({"Nothing broke: " + (name.empty() ? "it" : name) + " was " + text + "."});
}

namespace {

// By piece of a structure: its slot, or UINT32_MAX for one that is gone.
std::vector<uint32_t> slots_of(const Simulation& simulation, const physics::Structure& structure) {
    std::vector<uint32_t> slots(structure.piece_count(), UINT32_MAX);
    const physics::Destruction* destruction = simulation.destruction();
    if (!destruction) {
        std::iota(slots.begin(), slots.end(), 0u);
        return slots;
    }
    for (const physics::PieceId piece : destruction->pieces())
        if (const auto [own, index] = simulation.bonds_of(piece.value); own == &structure)
            slots[index] = destruction->slot(piece);
    return slots;
}

} // namespace

void Session::add_bond_lines(std::vector<engine::LineVertex>& lines) const {
    const physics::Structure* structure = stage_->simulation().structure();
    if (!structure) return;
    const std::vector<uint32_t> slots = slots_of(stage_->simulation(), *structure);
    const auto bonds_of = structure->graph().bonds();
    const auto ratios = structure->wear().ratios();
    for (size_t k = 0; k < bonds_of.size(); ++k) {
        const auto& bond = bonds_of[k];
        if (!bond.live() || std::max(slots[bond.a], slots[bond.b]) >= poses_.size()) continue;
        const double load = std::clamp(k < ratios.size() ? ratios[k] / bond.health : 0.0, 0.0, 1.0);
        const uint32_t colour = bond_colour(load);
        lines.push_back({poses_[slots[bond.a]].position, colour});
        lines.push_back({poses_[slots[bond.b]].position, colour});
    }
}

engine::Scene Session::scene(const engine::Camera& camera) {
    const PictureOptions& view = recipe().picture;
    stage_->show_hulls(view.hulls);
    stage_->explode(view.explode);
    stage_->colour_by(view.colours);
    stage_->dust(view.dust);
    const bool marks_sites =
        !broken() && (view.sites || preview_.wanted) && !preview_.aims_at_whole() && recipe().strikes.empty();
    stage_->show_sites(marks_sites || (broken() && view.sites) ? std::span(sites_.on_stage())
                                                               : std::span<const glm::dvec3>());
    lines_.clear();
    if (broken() && bonds && !object_->is_scene()) add_bond_lines(lines_);
    const Cracked* shown = preview_.shown();
    if (shown && !shown->ghost && view.cells) lines_ = shown->cells;
    if (shown) lines_.insert(lines_.end(), shown->cracks.begin(), shown->cracks.end());
    preview_.add_cracks_ahead(lines_);
    if (!playing_) add_boxes_of_selected(lines_);
    stage_->show_lines(lines_);
    engine::Scene scene = stage_->scene();
    // Only a part broke: the rest keeps its look.
    if (broken() && !recipe().strikes.empty()) scene.look.tint = std::min(scene.look.tint, tint_of_the_struck);
    if (shown) { // pieces to come, whose colours tell them apart
        scene.look.tint = preview_tint;
        scene.materials = false;
    }
    if (broken() && scene.write_poses) {
        if (const physics::Destruction* destruction = stage_->simulation().destruction())
            poses_.resize(destruction->slot_count());
        scene.write_poses(poses_, 0);
    }
    scene.camera = camera;
    place_lines(scene);
    scene.smooth = view.smooth;
    scene.wireframe = view.wireframe;
    return scene;
}

// Bonds are visible through pieces. Cracks lie on pieces. Of hulls only the front is visible: all of them would be a
// tangle.
void Session::place_lines(engine::Scene& scene) {
    const bool hulls_alone = broken() && recipe().picture.hulls && !bonds;
    if (preview_.current() || hulls_alone) scene.lines_on_top = false;
    if (!hulls_alone) return;
    lines_.assign(scene.lines.begin(), scene.lines.end());
    for (engine::LineVertex& v : lines_) v.position += hull_lift * (scene.camera.eye - v.position);
    scene.lines = lines_;
}

bool Session::is_still() const {
    if (preview_.busy() || single_step_ || moved_) return false;
    return playback.paused || !playing_ || stage_->still();
}

bool Session::quiet() const {
    return activity_.idle() && is_still();
}

bool Session::only_works() const {
    return activity_.busy() && !activity_.has_results() && is_still();
}

bool Session::take_fracture_mark() {
    return std::exchange(fractured_, false);
}

} // namespace brittle::tools
