// The session's part for scenes: selection, edits of objects, and the stage that follows them.
#include "tools/brittle/studio/session.h"

#include <algorithm>
#include <array>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "tools/scenario/recipe/recipe.h"

namespace brittle::tools {

namespace {

const uint32_t selection_colour = engine::srgb8(236, 142, 66);

// The motion that takes an object from one place to another.
physics::Pose motion_between(const physics::Pose& from, const physics::Pose& to) {
    const glm::quat turn = to.orientation * glm::conjugate(from.orientation);
    return {to.position - turn * from.position, turn};
}

} // namespace

// The objects stand at their places; time has not begun.
void Session::stand_scene(std::vector<PreparedObject> parts) {
    WorldOptions world = object_->scene().world;
    world.engine = recipe().world.engine;
    recorder_->use_recipe(recipe());
    stage_->stand(std::move(parts), world);
    stood_.clear();
    for (const LoadedObject& object : object_->scene().objects) stood_.push_back(object.placement);
    show_hidden();
    poses_ = poses_by_slot(stage_->simulation());
    counts_ = {static_cast<uint32_t>(stage_->simulation().piece_count()), 0, 0.0, {}, {}};
}

// The objects are drawn at their places while they are being prepared.
void Session::show_scene() {
    stage_->show(object_->meshes());
    stood_.clear();
    for (const LoadedObject& object : object_->scene().objects) stood_.push_back(object.placement);
    show_hidden();
    poses_.clear();
    counts_.reset();
}

bool Session::reads() const {
    return !activity_.idle() && reads_ >= valid_reads_;
}

// Makes the stage show the recipe before time begins. Returns false while the scene is prepared or read; an attempt that
// failed is repeated.
bool Session::stand_now() {
    if (!object_->is_scene()) return true;
    if (moved_ && object_->is_prepared()) {
        valid_reads_ = reads_ + 1;
        make_stage();
    }
    if (!object_->is_prepared() && !moved_ && !reads()) read_object();
    return !moved_ && !reads();
}

void Session::once_it_stands(const std::string& what, std::function<void()> action) {
    due_ = std::move(action);
    activity_.say({"The scene is still being prepared: " + what + " as soon as it is ready."});
}

// Follows an edit that changes nothing but places: the objects are drawn where the recipe puts them, and the stage is
// made anew once the mouse is released, or time begins. Returns whether the edit was of this kind.
bool Session::follow_places() {
    std::shared_ptr<const Object> placed = object_->placed_as(recipe());
    if (!placed) return false;
    object_ = std::move(placed);
    valid_reads_ = reads_ + 1;
    if (activity_.message().fault) activity_.say({}); // of an edit that is undone
    if (playing_) {
        make_stage();
        return true;
    }
    const bool stands = std::ranges::equal(stood_, object_->scene().objects, [](const physics::Pose& a, const auto& b) {
        return a.position == b.placement.position && a.orientation == b.placement.orientation;
    });
    moved_ = !stands || !object_->is_prepared();
    std::vector<physics::Pose> moves;
    const std::vector<LoadedObject>& objects = object_->scene().objects;
    for (size_t k = 0; k < objects.size(); ++k) moves.push_back(motion_between(stood_[k], objects[k].placement));
    stage_->carry(std::move(moves));
    return true;
}

// Says what is wrong with a level, then which objects of a scene cannot be broken, and why.
void Session::tell_notes() {
    std::string text;
    const std::vector<std::string>& own = object_->is_scene() ? object_->scene().notes : object_->look_notes();
    for (const std::vector<std::string>& notes : {std::exchange(level_notes_, {}), own})
        for (const std::string& note : notes) text += (text.empty() ? "" : "\n") + note;
    if (!text.empty()) activity_.say({text, true});
}

void Session::select(uint32_t object, bool add) {
    if (object >= recipe().objects.size()) return; // it was removed a moment ago, and is still on the stage
    const auto at = std::ranges::find(selected, object);
    if (!add)
        selected = {object};
    else if (at == selected.end())
        selected.push_back(object);
    else
        selected.erase(at);
}

void Session::change_selected(const std::function<void(SceneObject&)>& change, uint64_t gesture) {
    std::vector<SceneObject> objects = recipe().objects;
    for (const uint32_t k : selected) change(objects[k]);
    edit(SetObjects{std::move(objects)}, gesture);
}

void Session::duplicate_selected() {
    constexpr double beside = 0.1; // m, so that copies are visible beside the originals
    std::vector<SceneObject> objects = recipe().objects;
    const auto first = static_cast<uint32_t>(objects.size());
    for (const uint32_t k : selected) {
        objects.push_back(objects[k]);
        objects.back().placement.translation.x += beside;
    }
    edit(SetObjects{std::move(objects)});
    selected.clear();
    for (uint32_t k = first; k < recipe().objects.size(); ++k) selected.push_back(k);
}

void Session::add_object(const std::string& mesh, const std::optional<glm::dvec3>& at) {
    std::vector<SceneObject> objects = recipe().objects;
    objects.emplace_back();
    objects.back().name = mesh_name(mesh);
    objects.back().recipe.mesh = mesh;
    const uint64_t gesture = begin_gesture();
    std::optional<glm::dvec3> place = at;
    if (!place && camera_) {
        const glm::dvec3 eye(camera_->eye), way(camera_->target - camera_->eye);
        if (glm::length(way) > 0.0) place = surface_at(eye, glm::normalize(way), {});
    }
    selected = {static_cast<uint32_t>(objects.size() - 1)};
    edit(SetObjects{std::move(objects)}, gesture);
    lay_down_ = LayDown{recipe().objects.back().name, place.value_or(glm::dvec3(0.0)), gesture};
}

// Moves an object that was added so that the middle of its foot is at a point.
void Session::lay_down() {
    if (!lay_down_) return;
    const std::optional<uint32_t> k = object_named(lay_down_->name);
    if (!k || *k >= object_->scene().objects.size()) return; // it is still being read
    const LayDown lay = *std::exchange(lay_down_, std::nullopt);
    const LoadedObject& object = object_->scene().objects[*k];
    if (object.object.name != lay.name) return;
    ObjectPlacement place = recipe().objects[*k].placement;
    const glm::dvec3 centre = object.box.centre();
    place.translation += lay.at - glm::dvec3(centre.x, object.box.min.y, centre.z);
    place.translation = glm::round(place.translation * 1e6) / 1e6 + 0.0; // micrometres are enough
    set_places({{*k}}, {{place}}, lay.gesture);
}

void Session::set_places(std::span<const uint32_t> which, std::span<const ObjectPlacement> places, uint64_t gesture) {
    std::vector<SceneObject> objects = recipe().objects;
    for (size_t k = 0; k < which.size(); ++k)
        if (which[k] < objects.size()) objects[which[k]].placement = places[k];
    edit(SetObjects{std::move(objects)}, gesture);
}

std::optional<engine::Bounds> Session::box_of_selected() const {
    if (!object_->is_scene() || playing_) return std::nullopt;
    const std::vector<LoadedObject>& objects = object_->scene().objects;
    std::optional<engine::Bounds> around;
    for (const uint32_t k : selected) {
        if (k >= objects.size()) continue;
        const engine::Bounds box{glm::vec3(objects[k].box.min), glm::vec3(objects[k].box.max)};
        around = around ? engine::join(*around, box) : box;
    }
    return around;
}

std::optional<glm::vec3> Session::middle_of_selected() const {
    const auto around = box_of_selected();
    return around ? std::optional(around->centre()) : std::nullopt;
}

void Session::select_within(const std::function<bool(const glm::vec3& corner)>& contains) {
    if (!object_->is_scene()) return;
    const std::vector<LoadedObject>& objects = object_->scene().objects;
    for (uint32_t k = 0; k < objects.size() && k < recipe().objects.size(); ++k) {
        if (is_hidden(k) || is_locked(k) || std::ranges::find(selected, k) != selected.end()) continue;
        const std::array<glm::vec3, 2> ends{glm::vec3(objects[k].box.min), glm::vec3(objects[k].box.max)};
        bool all = true;
        for (size_t c = 0; c < 8 && all; ++c)
            all = contains({ends[c & 1].x, ends[(c >> 1) & 1].y, ends[(c >> 2) & 1].z});
        if (all) selected.push_back(k);
    }
}

std::optional<glm::dvec3> Session::surface_at(const glm::dvec3& from, const glm::dvec3& direction,
                                              std::span<const uint32_t> except) const {
    const Simulation& simulation = stage_->simulation();
    const auto skips = [&](uint32_t id) {
        const uint32_t member = simulation.member_of(id);
        return is_hidden(member) || std::ranges::find(except, member) != except.end();
    };
    const auto hit = pieces().first(from, direction, skips);
    const double ground = direction.y != 0.0 ? -from.y / direction.y : -1.0; // the plane y = 0
    if (hit && !(ground > 0.0 && ground < hit->distance)) return glm::dvec3(hit->point);
    return ground > 0.0 ? std::optional(from + ground * direction) : std::nullopt;
}

// --- hidden and locked objects ---

const std::string* Session::name_on_stage(uint32_t object) const {
    if (!object_->is_scene() || object >= object_->scene().objects.size()) return nullptr;
    return &object_->scene().objects[object].object.name;
}

std::optional<uint32_t> Session::object_named(const std::string& name) const {
    const auto at = std::ranges::find(recipe().objects, name, &SceneObject::name);
    if (at == recipe().objects.end()) return std::nullopt;
    return static_cast<uint32_t>(at - recipe().objects.begin());
}

bool Session::is_hidden(uint32_t object) const {
    const std::string* name = name_on_stage(object);
    return name && hidden_.contains(*name);
}

bool Session::is_locked(uint32_t object) const {
    const std::string* name = name_on_stage(object);
    return name && locked_.contains(*name);
}

void Session::hide(uint32_t object, bool hidden) {
    if (object >= recipe().objects.size()) return;
    const std::string& name = recipe().objects[object].name;
    hidden ? static_cast<void>(hidden_.insert(name)) : static_cast<void>(hidden_.erase(name));
    show_hidden();
}

void Session::lock(uint32_t object, bool locked) {
    if (object >= recipe().objects.size()) return;
    const std::string& name = recipe().objects[object].name;
    locked ? static_cast<void>(locked_.insert(name)) : static_cast<void>(locked_.erase(name));
}

void Session::rename(uint32_t object, const std::string& name, uint64_t gesture) {
    if (object >= recipe().objects.size() || name.empty()) return;
    const std::string before = recipe().objects[object].name;
    std::vector<SceneObject> objects = recipe().objects;
    objects[object].name = name;
    edit(SetObjects{std::move(objects)}, gesture);
    const std::string& after = recipe().objects[object].name; // with a number, where another one has the name
    for (std::set<std::string>* names : {&hidden_, &locked_})
        if (names->contains(before)) names->insert(after); // the old name stays, for undo
}

void Session::forget_marks() {
    hidden_.clear();
    locked_.clear();
    lay_down_.reset();
}

void Session::show_hidden() {
    if (!object_->is_scene()) return;
    std::vector<bool> hidden;
    for (uint32_t k = 0; k < object_->scene().objects.size(); ++k) hidden.push_back(is_hidden(k));
    stage_->hide(std::move(hidden));
}

std::optional<PieceHit> Session::first_piece(const glm::dvec3& from, const glm::dvec3& direction, bool selects) const {
    if (hidden_.empty() && locked_.empty()) return pieces().first(from, direction);
    return pieces().first(from, direction, [&](uint32_t id) {
        const uint32_t member = stage_->simulation().member_of(id);
        return is_hidden(member) || (selects && is_locked(member));
    });
}

std::optional<uint32_t> Session::first_object(const glm::dvec3& from, const glm::dvec3& direction, bool selects) const {
    if (broken()) {
        const auto hit = first_piece(from, direction, selects);
        return hit ? std::optional(stage_->simulation().member_of(hit->piece)) : std::nullopt;
    }
    return object_->object_along(from, direction,
                                 [&](uint32_t k) { return is_hidden(k) || (selects && is_locked(k)); });
}

void Session::remove_selected() {
    std::vector<SceneObject> kept;
    for (uint32_t k = 0; k < recipe().objects.size(); ++k)
        if (std::ranges::find(selected, k) == selected.end()) kept.push_back(recipe().objects[k]);
    if (kept.empty()) {
        activity_.say({"A scene needs an object: the last one stays."});
        return;
    }
    edit(SetObjects{std::move(kept)});
    selected.clear();
}

void Session::add_boxes_of_selected(std::vector<engine::LineVertex>& lines) const {
    if (!object_->is_scene()) return;
    const std::vector<LoadedObject>& objects = object_->scene().objects; // as before an edit that is being read
    for (const uint32_t k : selected) {
        if (k >= objects.size()) continue;
        const std::array<glm::vec3, 2> ends{glm::vec3(objects[k].box.min), glm::vec3(objects[k].box.max)};
        const auto corner = [&](size_t c) {
            return glm::vec3(ends[c & 1].x, ends[(c >> 1) & 1].y, ends[(c >> 2) & 1].z);
        };
        for (size_t c = 0; c < 8; ++c)
            for (const size_t axis : {1u, 2u, 4u})
                if ((c & axis) == 0) {
                    lines.push_back({corner(c), selection_colour});
                    lines.push_back({corner(c | axis), selection_colour});
                }
    }
}

} // namespace brittle::tools
