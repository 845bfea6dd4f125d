// The session's part for scenes: selection, edits of objects, and the stage that follows them.
#include "tools/brittle/studio/session.h"

#include <algorithm>
#include <utility>

#include <glm/gtc/quaternion.hpp>

#include "tools/brittle/recipe/recipe.h"

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
    poses_ = poses_by_slot(stage_->simulation());
    counts_ = {static_cast<uint32_t>(stage_->simulation().piece_count()), 0, 0.0, {}, {}};
}

bool Session::reads() const {
    return !activity_.idle() && reads_ >= valid_reads_;
}

// Makes the stage show the recipe before time begins. Returns false while the scene is read.
bool Session::stand_now() {
    if (!object_->is_scene()) return true;
    if (moved_ && object_->is_prepared()) {
        valid_reads_ = reads_ + 1;
        make_stage();
    }
    return !moved_ && !reads();
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
void Session::tell_notes(std::span<const std::string> of_level) {
    std::string text;
    for (const std::span<const std::string> notes : {of_level, std::span<const std::string>(object_->scene().notes)})
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

void Session::add_object(const std::string& mesh) {
    std::vector<SceneObject> objects = recipe().objects;
    objects.emplace_back();
    objects.back().name = mesh_name(mesh);
    objects.back().recipe.mesh = mesh;
    selected = {static_cast<uint32_t>(objects.size() - 1)};
    edit(SetObjects{std::move(objects)});
}

std::optional<glm::vec3> Session::middle_of_selected() const {
    if (!object_->is_scene() || playing_) return std::nullopt;
    const std::vector<LoadedObject>& objects = object_->scene().objects;
    std::optional<engine::Bounds> around;
    for (const uint32_t k : selected) {
        if (k >= objects.size()) continue;
        const engine::Bounds box{glm::vec3(objects[k].box.min), glm::vec3(objects[k].box.max)};
        around = around ? engine::join(*around, box) : box;
    }
    return around ? std::optional(around->centre()) : std::nullopt;
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
