#include "tools/brittle/studio/session.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <glm/geometric.hpp>

#include "tools/brittle/base/failure.h"
#include "tools/brittle/recipe/recipe.h"

namespace brittle::tools {

namespace {

constexpr float preview_tint = 0.8f;
constexpr float tint_of_the_struck = 0.12f;
constexpr double physics_step = 1.0 / 120.0; // s, of World

bool same_sites(const FractureOptions& a, const FractureOptions& b) {
    const auto how = [](const FractureOptions& options) {
        FractureOptions only;
        only.pattern = options.pattern;
        only.sites_file = options.sites_file;
        only.points = options.points;
        only.fit_sites = options.fit_sites;
        only.sites_placement = options.sites_placement;
        only.min_volume = options.min_volume;
        only.algorithm = options.algorithm;
        return recipe_json(only);
    };
    return how(a) == how(b);
}

// From grey, idle, through yellow to red, about to break.
uint32_t bond_colour(double load) {
    const double up = std::min(1.0, 2.0 * load), down = std::max(0.0, 2.0 * load - 1.0);
    return engine::srgb8(static_cast<uint32_t>(100 + 150 * up), static_cast<uint32_t>(122 + 78 * up - 160 * down),
                         static_cast<uint32_t>(112 - 60 * up));
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
    find_sites();
}

Session::~Session() {
    worker_.cancel();
}

void Session::leave_piece() {
    shown_.reset();
    asked_.reset();
    cracks_ahead_.reset();
    asked_ahead_.reset();
    piece.reset();
}

void Session::make_stage() {
    stage_ = std::make_unique<Stage>(renderer_, fracture::bounds(object_->mesh()), object_->batch(), recipe().material);
    stage_->simulation().commit_as(physics::Timing::when_ready);
    stage_->simulation().observe(&*recorder_);
    ++stages_;
    shot_.reset(); // what waits for the pieces of another stage
    blow_.reset();
    leave_piece();
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
    if (now.mesh != before.mesh || now.repair != before.repair) {
        start("reading " + now.mesh, [this, now](const Worker::Cancelled&) {
            auto object = Object::load(now);
            post([this, object, mesh = now.mesh] {
                if (recipe().mesh == mesh) adopt(object);
            });
        });
        return;
    }
    const bool placed = now.world.anchored != before.world.anchored || now.world.height != before.world.height;
    const bool sites = !same_sites(now, before), strikes = !same_strikes(now, before);
    const bool anchors = now.world.anchors != before.world.anchors;
    if (placed) object_ = object_->placed_for(now.world);
    if (placed || now.material != before.material || ((sites || strikes || anchors) && (broken() || worker_.busy())))
        make_stage();
    if (placed || sites || strikes) {
        try {
            find_sites();
            if (!sites && !placed) return;
            message_ = {};
        } catch (const Failure& failure) {
            report(failure);
        }
        std::erase_if(selection, [this](uint32_t s) { return s >= sites_.size(); });
    }
}

void Session::adopt(std::shared_ptr<const Object> object) {
    object_ = std::move(object);
    selection.clear();
    counts_.reset();
    message_ = {};
    make_stage();
    try {
        find_sites();
    } catch (const Failure& failure) {
        report(failure);
    }
    if (opened) opened(recipe().mesh);
}

void Session::take_sites(uint64_t gesture) {
    if (!recipe().points.empty()) return;
    edit(SetSites{placed_}, gesture);
}

// Where no strike is. Throws a Failure, and has none then.
void Session::find_sites() {
    placed_.clear();
    sites_.clear();
    FractureOptions whole = recipe();
    whole.strikes.clear();
    placed_ = placed_sites(sites_for(whole, object_->file().model.mesh));
    for (const PlacedSite& site : placed_) sites_.push_back(object_->to_stage(site.at));
}

std::vector<PlacedSite> Session::selected_sites() const {
    std::vector<PlacedSite> sites;
    for (const uint32_t s : selection)
        if (s < placed_.size()) sites.push_back(placed_[s]);
    return sites;
}

std::vector<uint32_t> Session::fellows_of_selected() const {
    std::set<uint32_t> groups;
    for (const PlacedSite& site : selected_sites()) groups.insert(site.group);
    groups.erase(0);
    std::vector<uint32_t> fellows;
    for (uint32_t s = 0; s < placed_.size(); ++s)
        if (groups.contains(placed_[s].group)) fellows.push_back(s);
    return fellows;
}

Anchor Session::anchor_at(const glm::dvec3& on_stage) const {
    return {on_stage - glm::dvec3(0.0, foot_height(recipe().world), 0.0), double{tools.brush_radius}};
}

glm::dvec3 Session::on_stage(const Anchor& anchor) const {
    return anchor.at + glm::dvec3(0.0, foot_height(recipe().world), 0.0);
}

// --- what happens on the stage ---

void Session::break_all() {
    if (!recipe().strikes.empty()) edit(ClearStrikes{});
    if (broken() || worker_.busy()) return;
    WorldOptions world = recipe().world;
    if (starts_whole(world)) { // all of it falls apart, from where it stands
        world.height = foot_height(world);
        world.breakable = world.anchored = false;
        world.anchors.clear();
    }
    start_breaking(world);
}

void Session::strike(const glm::dvec3& at, const glm::dvec3& direction) {
    if (worker_.busy()) return;
    WorldOptions world = recipe().world;
    if (world.breakable) {
        blow_ = blow_at(at, direction);
    } else {
        edit(AddStrike{strike_at(at, direction)});
        world.bonded = holds_together(world);
    }
    start_breaking(world);
}

void Session::strike(const PieceHit& hit, const glm::dvec3& direction) {
    if (stage_->simulation().destruction()) {
        Simulation& simulation = stage_->simulation();
        simulation.apply(
            hammer_blow(simulation, hit, direction, double{tools.hammer_radius}, recipe().world.blow_pieces));
    } else { // where the place was when all was whole
        strike(glm::dvec3(hit.grip) + fragments_->pieces[hit.piece].mass.centre_of_mass, direction);
    }
}

void Session::shoot(const glm::vec3& from, const glm::vec3& direction) {
    if (broken()) {
        stage_->shoot({.from = glm::dvec3(from),
                       .velocity = glm::dvec3(tools.ball_speed * direction),
                       .radius = tools.ball_radius});
        return;
    }
    if (worker_.busy()) return;
    shot_ = {from, direction};
    WorldOptions world = recipe().world;
    world.bonded = world.bonded || !world.breakable;
    start_breaking(world);
}

void Session::grab(const PieceHit& hit) {
    stage_->simulation().apply(Grab{hit.piece, place_of(stage_->simulation(), hit)});
}

void Session::drag(const glm::vec3& to) {
    stage_->simulation().apply(Drag{glm::dvec3(to)});
}

void Session::let_go() {
    stage_->simulation().apply(LetGo{});
}

void Session::reset() {
    worker_.cancel();
    if (!recipe().strikes.empty()) edit(ClearStrikes{});
    counts_.reset();
    message_ = {};
    make_stage();
}

void Session::start_breaking(const WorldOptions& world) {
    FractureOptions options = recipe();
    options.world = world;
    start("breaking " + object_->name(), [this, object = object_, options,
                                          stage = stages_](const Worker::Cancelled& cancelled) {
        const WorldOptions stands = world_of(options);
        const Input input = object->with_sites(options);
        auto made = std::make_shared<Broken>(break_input(
            input, options, [this](double share) { work_share_ = share; }, classifier_, cancelled));
        auto ahead =
            std::make_shared<PreparedPieces>(prepare_pieces(renderer_, made->fragments, stands, options.material));
        post([this, made, ahead, stands, stage] {
            if (stages_ == stage) take_pieces(std::move(*made), std::move(*ahead), stands);
        });
    });
}

void Session::take_pieces(Broken made, PreparedPieces ahead, const WorldOptions& world) {
    leave_piece();
    recorder_->use_recipe(recipe());
    stage_->stand(made.fragments, world, std::move(ahead));
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
    message_ = {};
    if (const auto shot = std::exchange(shot_, std::nullopt)) shoot((*shot)[0], (*shot)[1]);
    if (const auto at = std::exchange(blow_, std::nullopt))
        if (const auto hammer = hammer_at(stage_->simulation(), *fragments_, *at, recipe().world.blow_pieces))
            stage_->simulation().apply(*hammer);
}

void Session::step_once() {
    playback.paused = true;
    single_step_ = true;
}

// --- work that takes long ---

void Session::start(const std::string& what, Worker::Task task) {
    work_name_ = what;
    work_share_ = -1.0;
    worker_.run([this, task = std::move(task)](const Worker::Cancelled& cancelled) {
        try {
            task(cancelled);
        } catch (const Failure& failure) {
            post([this, failure] { report(failure); });
        } catch (const std::bad_alloc&) {
            post([this] { say({"out of memory: use a smaller mesh or fewer sites", true}); });
        }
    });
}

void Session::post(std::function<void()> completion) {
    const std::scoped_lock lock(mutex_);
    completions_.push_back(std::move(completion));
}

void Session::report(const Failure& failure, const std::string& mend) {
    shot_.reset();
    if (failure.code() == exit_environment) throw failure; // the device is gone
    if (failure.code() == exit_interrupted)
        say({"cancelled"});
    else
        say({failure.what(), true, mend});
}

std::optional<Session::Work> Session::work() const {
    if (!worker_.busy()) return std::nullopt;
    return Work{work_name_, work_share_};
}

void Session::cancel() {
    worker_.cancel();
}

// --- each frame ---

void Session::update(double seconds) {
    std::vector<std::function<void()>> completions;
    {
        const std::scoped_lock lock(mutex_);
        completions.swap(completions_);
    }
    for (const auto& completion : completions) completion();
    update_preview();
    if (!broken()) return;
    if (std::exchange(single_step_, false)) {
        stage_->advance(physics_step);
    } else if (!playback.paused) {
        stage_->advance(seconds * playback.speed);
    }
    if (counts_) counts_->awake = stage_->world().awake_count();
    if (const physics::Destruction* destruction = stage_->simulation().destruction(); destruction && counts_)
        counts_->pieces = static_cast<uint32_t>(destruction->pieces().size());
    if (piece && !contains(*piece)) piece.reset(); // it was cut
}

void Session::add_bond_lines(std::vector<engine::LineVertex>& lines) const {
    const physics::Structure* structure = stage_->simulation().structure();
    if (!structure) return;
    const auto bonds_of = structure->graph().bonds();
    const auto ratios = structure->wear().ratios();
    for (size_t k = 0; k < bonds_of.size(); ++k) {
        const auto& bond = bonds_of[k];
        if (!bond.live() || bond.a >= poses_.size() || bond.b >= poses_.size()) continue;
        const double load = std::clamp(k < ratios.size() ? ratios[k] / bond.health : 0.0, 0.0, 1.0);
        const uint32_t colour = bond_colour(load);
        lines.push_back({poses_[bond.a].position, colour});
        lines.push_back({poses_[bond.b].position, colour});
    }
}

engine::Scene Session::scene(const engine::Camera& camera) {
    const PictureOptions& view = recipe().picture;
    stage_->show_hulls(view.hulls);
    stage_->explode(view.explode);
    const bool aimed = aimed_strike_ || aimed_blow_;
    const bool marks_sites = !broken() && (view.sites || preview_wanted) && !aimed && recipe().strikes.empty();
    stage_->show_sites(marks_sites || (broken() && view.sites) ? std::span(sites_) : std::span<const glm::dvec3>());
    lines_.clear();
    if (broken() && bonds) add_bond_lines(lines_);
    if (shown_ && !shown_->ghost && view.cells) lines_ = shown_->cells;
    if (shown_) lines_.insert(lines_.end(), shown_->cracks.begin(), shown_->cracks.end());
    add_cracks_ahead(lines_);
    stage_->show_lines(lines_);
    engine::Scene scene = stage_->scene();
    // Only a part broke: the rest is to look as before.
    if (broken() && !recipe().strikes.empty()) scene.look.tint = std::min(scene.look.tint, tint_of_the_struck);
    if (shown_) {
        scene.look.tint = preview_tint;
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

bool Session::quiet() const {
    if (worker_.busy() || preview_.busy() || single_step_) return false;
    const std::scoped_lock lock(mutex_);
    return completions_.empty() && (playback.paused || stage_->still());
}

bool Session::take_fracture_mark() {
    return std::exchange(fractured_, false);
}

} // namespace brittle::tools
