#include "tools/brittle/studio/tools.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace brittle::tools {

namespace {

constexpr float site_reach = 8.0f;   // pixels around a site that count as the site
constexpr float axis_reach = 7.0f;   // pixels beside an axis of the gizmo
constexpr float axis_length = 64.0f; // pixels
constexpr float click_slack = 4.0f;  // pixels that the mouse may move in a click
constexpr float dab_spacing = 8.0f;  // pixels of the mouse's path between two dabs of paint
constexpr int max_dabs = 100;        // maximum in one frame
constexpr float radius_step = 1.12f; // factor per notch of the wheel

constexpr std::array infos{
    ToolInfo{"Inspect", "F1", "drag to look around, click to select (Shift: more, Shift + drag: a box)"},
    ToolInfo{"Sites", "F2", "click to place a site, drag one to move it (Alt: halfway through, Ctrl: select more)"},
    ToolInfo{"Hammer", "F3", "click to break off what is near (Shift + wheel: radius)"},
    ToolInfo{"Shoot", "F4", "click to fire a ball (Shift + wheel: its radius)"},
    ToolInfo{"Grab", "F5", "drag a piece of what is broken about"},
    ToolInfo{"Anchors", "F6", "paint where it is held (Ctrl: rub out, Shift + wheel: radius)"},
};

glm::vec3 axis_vector(int axis) {
    glm::vec3 v(0.0f);
    v[axis] = 1.0f;
    return v;
}

float distance_to_segment(glm::vec2 p, glm::vec2 a, glm::vec2 b) {
    const glm::vec2 along = b - a;
    const float length = glm::dot(along, along);
    const float t = length > 0.0f ? std::clamp(glm::dot(p - a, along) / length, 0.0f, 1.0f) : 0.0f;
    return glm::distance(p, a + t * along);
}

} // namespace

const ToolInfo& info_of(Tool tool) {
    return infos[static_cast<size_t>(tool)];
}

void open_dropped(const engine::Input& input, const Viewport& view, Session& session) {
    if (input.dropped.empty()) return;
    const std::string& file = input.dropped.back();
    if (!session.object().is_scene() || file.ends_with(".json")) return session.files().open(file);
    const Ray ray = view.ray(input.cursor);
    session.add_object(file,
                       view.is_free(input.cursor) ? session.surface_at(ray.from, ray.direction, {}) : std::nullopt);
}

void Tools::choose(Tool tool, Session& session) {
    if (std::exchange(drag_, Drag::none) == Drag::grab) session.let_go();
    tool_ = tool;
    hovered_.reset();
    session.preview().aim_nowhere();
    session.preview().wanted = tool == Tool::sites;
}

void Tools::handle(const engine::Input& input, const Viewport& view, bool free, Session& session,
                   Navigation& navigation) {
    cursor_ = input.cursor;
    modifiers_ = input.modifiers;
    // Press, drag and release may all arrive in one slow frame.
    bool orbits = drag_ == Drag::orbit, right = right_, middle = middle_;
    for (const engine::ButtonEvent& event : input.buttons) {
        const bool pressed = event.down && free && view.is_free(event.cursor);
        if (event.button == engine::Button::right)
            right_ = pressed;
        else if (event.button == engine::Button::middle)
            middle_ = pressed;
        else if (pressed)
            press(event, view, session);
        else if (!event.down && left_)
            release(event, view, session);
        orbits |= drag_ == Drag::orbit;
        right |= right_;
        middle |= middle_;
    }
    if (right) input.modifiers.shift ? navigation.pan(input.drag_right) : navigation.orbit(input.drag_right);
    if (middle) navigation.pan(input.drag_middle);
    if (orbits)
        navigation.orbit(input.drag_left);
    else if (left_)
        drag_to(input.cursor, view, session);
    if (free && view.is_free(input.cursor)) {
        if (!input.modifiers.shift) {
            navigation.zoom(input.scroll, view, input.cursor);
        } else if (input.scroll != 0.0f) {
            const float factor = std::pow(radius_step, input.scroll);
            float& radius = tool_ == Tool::shoot     ? session.tools.ball_radius
                            : tool_ == Tool::anchors ? session.tools.brush_radius
                                                     : session.tools.hammer_radius;
            radius = std::clamp(radius * factor, 0.02f, tool_ == Tool::hammer ? 1.5f : 0.5f);
        }
    }
    aim(input, view, free, session);
}

void Tools::press(const engine::ButtonEvent& event, const Viewport& view, Session& session) {
    left_ = true;
    pressed_at_ = event.cursor;
    drag_ = Drag::none;
    if (event.modifiers.alt && tool_ != Tool::sites) {
        drag_ = Drag::orbit;
        return;
    }
    const Ray ray = view.ray(event.cursor);
    switch (tool_) {
    case Tool::inspect:
        press_inspect(event, view, session);
        break;
    case Tool::sites:
        press_sites(event, view, session);
        break;
    case Tool::anchors:
        press_anchors(event, view, session);
        break;
    case Tool::hammer:
        session.strike_along(ray.from, ray.direction);
        break;
    case Tool::shoot:
        session.shoot(glm::vec3(ray.from), glm::vec3(ray.direction));
        break;
    case Tool::grab:
        if (const auto hit = session.first_piece(ray.from, ray.direction)) {
            drag_ = Drag::grab;
            target_ = hit->point;
            session.grab(*hit);
        } else if (!session.broken() && !session.object().is_scene()) {
            session.activity().say({"It is still whole: Space breaks it, then pieces can be grabbed."});
        }
        break;
    }
}

void Tools::release(const engine::ButtonEvent& event, const Viewport& view, Session& session) {
    modifiers_ = event.modifiers;
    const bool clicked = glm::distance(event.cursor, pressed_at_) <= click_slack;
    if (tool_ == Tool::inspect && clicked && (drag_ == Drag::orbit || drag_ == Drag::box)) {
        click_inspect(event, view, session);
    } else if (drag_ == Drag::box) {
        const glm::vec2 low = glm::min(event.cursor, pressed_at_), high = glm::max(event.cursor, pressed_at_);
        session.select_within([&](const glm::vec3& corner) {
            const auto at = view.pixel(corner);
            return at && glm::clamp(*at, low, high) == *at;
        });
    }
    drag_to(event.cursor, view, session); // the rest of the path
    left_ = false;
    held_.reset();
    if (std::exchange(drag_, Drag::none) == Drag::grab) session.let_go();
}

// A handle of the gizmo is dragged; with Shift, a box is drawn; else the view turns.
void Tools::press_inspect(const engine::ButtonEvent& event, const Viewport& view, Session& session) {
    const bool edits = session.object().is_scene() && !session.playing();
    const auto frame = gizmo_frame(session);
    const auto handle = frame ? gizmo_handle_at(event.cursor, gizmo_shape(gizmo_, *frame, view)) : std::nullopt;
    if (!handle) {
        drag_ = edits && event.modifiers.shift ? Drag::box : Drag::orbit;
        return;
    }
    drag_ = Drag::gizmo;
    gesture_ = session.begin_gesture();
    held_.emplace(*handle, *frame, event.cursor, view);
    held_box_ = session.box_of_selected().value_or(engine::Bounds{});
    held_objects_ = session.selected;
    held_places_.clear();
    held_text_.clear();
    for (const uint32_t k : held_objects_) held_places_.push_back(session.recipe().objects[k].placement);
}

void Tools::click_inspect(const engine::ButtonEvent& event, const Viewport& view, Session& session) const {
    const Ray ray = view.ray(event.cursor);
    const bool selects = !session.playing();
    const auto hit = session.first_piece(ray.from, ray.direction, selects);
    session.piece = hit ? std::optional(hit->piece) : std::nullopt;
    if (!session.object().is_scene()) return;
    if (const auto object = session.first_object(ray.from, ray.direction, selects))
        session.select(*object, event.modifiers.shift);
    else if (!event.modifiers.shift)
        session.selected.clear();
}

// The gizmo stands in the middle of the selected objects. A single one is scaled along its own axes.
std::optional<GizmoFrame> Tools::gizmo_frame(const Session& session) const {
    if (tool_ != Tool::inspect) return std::nullopt;
    const auto middle = session.middle_of_selected();
    if (!middle) return std::nullopt;
    GizmoFrame frame{glm::dvec3(*middle)};
    const std::vector<SceneObject>& objects = session.recipe().objects;
    if (gizmo_ == GizmoMode::scale && session.selected.size() == 1 && session.selected[0] < objects.size()) {
        frame.axes = glm::mat3_cast(rotation_of(objects[session.selected[0]].placement));
        frame.own = true;
    }
    return frame;
}

void Tools::drag_gizmo(glm::vec2 cursor, const Viewport& view, Session& session) {
    if (!held_ || session.selected != held_objects_) return;
    const GizmoHandle& handle = held_->handle();
    if (handle.mode == GizmoMode::move && handle.axis == 3 && modifiers_.shift) {
        lay_on_surface(cursor, view, session);
        return;
    }
    const GizmoChange change = held_->change(cursor, view, modifiers_.control);
    held_text_ = held_->text(change);
    std::vector<ObjectPlacement> places;
    for (const ObjectPlacement& before : held_places_) places.push_back(held_->place(before, change));
    session.set_places(held_objects_, places, gesture_);
}

// Moves the held objects so that the middle of their foot is on the surface under the cursor.
void Tools::lay_on_surface(glm::vec2 cursor, const Viewport& view, Session& session) {
    const Ray ray = view.ray(cursor);
    const auto at = session.surface_at(ray.from, ray.direction, held_objects_);
    if (!at) return;
    const glm::dvec3 centre(held_box_.centre());
    const GizmoChange change{.move = *at - glm::dvec3(centre.x, double{held_box_.min.y}, centre.z)};
    held_text_ = "on the surface";
    std::vector<ObjectPlacement> places;
    for (const ObjectPlacement& before : held_places_) places.push_back(held_->place(before, change));
    session.set_places(held_objects_, places, gesture_);
}

// Begins to drag the selected sites along an axis.
void Tools::hold_axis(int axis, glm::vec2 pixel, const Viewport& view, Session& session) {
    gesture_ = session.begin_gesture();
    drag_ = Drag::axis;
    axis_ = axis;
    dragged_ = on_axis(view.ray(pixel), glm::dvec3(*gizmo_at(session)), glm::dvec3(axis_vector(axis)));
}

void Tools::press_sites(const engine::ButtonEvent& event, const Viewport& view, Session& session) {
    if (const auto axis = axis_at(event.cursor, view, session)) {
        hold_axis(*axis, event.cursor, view, session);
        session.take_sites(gesture_);
        return;
    }
    gesture_ = session.begin_gesture();
    const auto site = site_at(event.cursor, view, session);
    if (!site) {
        place_site(event, view, session);
        return;
    }
    auto& selection = session.sites().selection;
    const auto at = std::find(selection.begin(), selection.end(), *site);
    if (event.modifiers.control) {
        at == selection.end() ? selection.push_back(*site) : static_cast<void>(selection.erase(at));
        return;
    }
    if (at == selection.end()) selection = {*site};
    drag_ = Drag::site;
    dragged_ = on_view_plane(view.ray(event.cursor), session.sites().on_stage()[*site], view);
}

// Places a site on the surface, or with Alt in the middle of the first part of the solid that the ray passes.
void Tools::place_site(const engine::ButtonEvent& event, const Viewport& view, Session& session) {
    const Ray ray = view.ray(event.cursor);
    if (session.broken() || session.object().is_scene()) {
        session.activity().say({session.object().is_scene()
                                    ? "Sites are placed on one mesh: open the mesh of an object by itself."
                                    : "R makes it whole again; then sites can be placed."});
        return;
    }
    const auto hit = session.object().first_hit(ray.from, ray.direction);
    if (!hit) {
        session.sites().selection.clear();
        return;
    }
    glm::dvec3 at = hit->point;
    if (event.modifiers.alt) at = 0.5 * (hit->point + session.object().exit_after(*hit, ray.direction).point);
    session.take_sites(gesture_);
    session.edit(AddSite{session.object().to_file(at)}, gesture_);
    session.sites().selection = {static_cast<uint32_t>(session.sites().on_stage().size() - 1)};
}

void Tools::press_anchors(const engine::ButtonEvent& event, const Viewport& view, Session& session) {
    if (session.broken() || session.object().is_scene()) {
        session.activity().say({session.object().is_scene()
                                    ? "Spots are painted on one mesh; in a scene an object is anchored by its recipe."
                                    : "R makes it whole again; then it can be anchored."});
        return;
    }
    gesture_ = session.begin_gesture();
    drag_ = event.modifiers.control ? Drag::rub_out : Drag::paint;
    painted_to_ = event.cursor;
    paint(view.ray(event.cursor), session);
}

// Paints along the path of the mouse, which is long in a slow frame.
void Tools::paint_along(glm::vec2 to, const Viewport& view, Session& session) {
    const float way = glm::distance(to, painted_to_);
    const int dabs = std::min(static_cast<int>(std::ceil(way / dab_spacing)), max_dabs);
    for (int k = 1; k <= dabs; ++k)
        paint(view.ray(glm::mix(painted_to_, to, static_cast<float>(k) / static_cast<float>(dabs))), session);
    painted_to_ = to;
}

// Paints or removes anchors. New anchors keep a distance at which their balls still cover the path between them.
void Tools::paint(const Ray& ray, Session& session) {
    const auto hit = session.object().first_hit(ray.from, ray.direction);
    if (!hit) return;
    const Anchor spot = session.anchor_at(hit->point);
    const std::vector<Anchor>& anchors = session.recipe().world.anchors;
    std::vector<uint32_t> near;
    for (uint32_t k = 0; k < anchors.size(); ++k) {
        const double reach = drag_ == Drag::rub_out ? anchors[k].radius : 0.5 * spot.radius;
        if (glm::distance(anchors[k].at, spot.at) < reach) near.push_back(k);
    }
    if (drag_ == Drag::rub_out)
        session.edit(RemoveAnchors{near}, gesture_);
    else if (near.empty())
        session.edit(AddAnchor{spot}, gesture_);
}

void Tools::drag_to(glm::vec2 cursor, const Viewport& view, Session& session) {
    const Ray ray = view.ray(cursor);
    if (drag_ == Drag::paint || drag_ == Drag::rub_out) {
        paint_along(cursor, view, session);
        return;
    }
    if (drag_ == Drag::grab) {
        target_ = glm::vec3(on_view_plane(ray, glm::dvec3(target_), view));
        session.drag(target_);
        return;
    }
    if (drag_ == Drag::gizmo) {
        drag_gizmo(cursor, view, session);
        return;
    }
    if (drag_ != Drag::site && drag_ != Drag::axis) return;
    if (drag_ == Drag::site && glm::distance(cursor, pressed_at_) <= click_slack && session.recipe().points.empty())
        return;
    const glm::dvec3 now = drag_ == Drag::site ? on_view_plane(ray, dragged_, view)
                                               : on_axis(ray, dragged_, glm::dvec3(axis_vector(axis_)));
    const glm::dvec3 by = (now - dragged_) / session.object().scale();
    if (by == glm::dvec3(0.0)) return;
    dragged_ = now;
    session.take_sites(gesture_);
    session.edit(MoveSites{session.sites().selection, by}, gesture_);
}

void Tools::aim(const engine::Input& input, const Viewport& view, bool free, Session& session) {
    hovered_.reset();
    aimed_.reset();
    over_.reset();
    const bool over = free && view.is_free(input.cursor);
    if (const auto frame = over && !left_ ? gizmo_frame(session) : std::nullopt)
        over_ = gizmo_handle_at(input.cursor, gizmo_shape(gizmo_, *frame, view));
    if (tool_ == Tool::sites && over && !left_) hovered_ = site_at(input.cursor, view, session);
    if (tool_ == Tool::hammer) session.preview().aim_nowhere();
    if (!over) return;
    const Ray ray = view.ray(input.cursor);
    const bool turning = right_ || middle_; // the view turns, and a preview would lag behind
    if (tool_ == Tool::anchors && !session.broken() && !turning)
        if (const auto hit = session.object().first_hit(ray.from, ray.direction)) aimed_ = glm::vec3(hit->point);
    if (tool_ != Tool::hammer) return;
    if (session.broken()) {
        const auto hit = session.first_piece(ray.from, ray.direction);
        if (!hit) return;
        aimed_ = hit->point;
        if (!turning) session.preview().aim(*hit, ray.direction);
    } else if (const auto hit = session.object().first_hit(ray.from, ray.direction); hit && !turning) {
        aimed_ = glm::vec3(hit->point);
        session.preview().aim(hit->point, ray.direction);
    }
}

// Returns the site nearest to the eye among those near the cursor.
std::optional<uint32_t> Tools::site_at(glm::vec2 pixel, const Viewport& view, const Session& session) const {
    if (session.broken()) return std::nullopt;
    std::optional<uint32_t> best;
    double nearest = 0.0;
    for (uint32_t s = 0; s < session.sites().on_stage().size(); ++s) {
        const auto at = view.pixel(glm::vec3(session.sites().on_stage()[s]));
        if (!at || glm::distance(*at, pixel) > site_reach) continue;
        const double distance = glm::distance(session.sites().on_stage()[s], glm::dvec3(view.camera().eye));
        if (best && distance >= nearest) continue;
        best = s;
        nearest = distance;
    }
    return best;
}

std::optional<glm::vec3> Tools::gizmo_at(const Session& session) const {
    if (tool_ != Tool::sites || session.broken() || session.sites().selection.empty()) return std::nullopt;
    glm::dvec3 sum(0.0);
    for (const uint32_t s : session.sites().selection) sum += session.sites().on_stage()[s];
    return glm::vec3(sum / static_cast<double>(session.sites().selection.size()));
}

std::optional<int> Tools::axis_at(glm::vec2 pixel, const Viewport& view, const Session& session) const {
    for (const Overlay::Axis& axis : overlay(view, session).axes) {
        // The first third of an axis belongs to the site itself.
        if (distance_to_segment(pixel, axis.from + (axis.to - axis.from) / 3.0f, axis.to) <= axis_reach)
            return axis.axis;
    }
    return std::nullopt;
}

// Rings around the sites that are selected, of their groups, or under the cursor; and the sites without effect.
void Tools::ring_sites(const Viewport& view, const Session& session, Overlay& overlay) const {
    const auto ring = [&](uint32_t s, bool strong) {
        if (s >= session.sites().on_stage().size()) return;
        if (const auto at = view.pixel(glm::vec3(session.sites().on_stage()[s])))
            overlay.circles.push_back({*at, 10.0f, strong});
    };
    for (const uint32_t s : session.preview().idle_sites())
        if (const auto at = view.pixel(glm::vec3(session.sites().on_stage()[s]))) overlay.idle.push_back(*at);
    for (const uint32_t s : session.sites().fellows_of_selected()) ring(s, false);
    for (const uint32_t s : session.sites().selection) ring(s, true);
    if (hovered_) ring(*hovered_, false);
}

Overlay Tools::overlay(const Viewport& view, const Session& session) const {
    Overlay overlay;
    if (tool_ == Tool::hammer && aimed_)
        overlay.circles.push_back({cursor_, session.tools.hammer_radius * view.pixels_a_metre(*aimed_), true});
    if (tool_ == Tool::anchors) {
        if (aimed_)
            overlay.circles.push_back({cursor_, session.tools.brush_radius * view.pixels_a_metre(*aimed_), true});
        for (const Anchor& anchor : session.recipe().world.anchors) {
            const auto centre = glm::vec3(session.on_stage(anchor));
            const float radius = static_cast<float>(anchor.radius) * view.pixels_a_metre(centre);
            if (const auto at = view.pixel(centre)) overlay.spots.push_back({*at, radius});
        }
    }
    if (tool_ == Tool::shoot) overlay.circles.push_back({cursor_, 6.0f, true});
    if (drag_ == Drag::grab)
        if (const auto at = view.pixel(target_)) overlay.string = {*at, cursor_};
    if (tool_ == Tool::sites && !session.broken()) ring_sites(view, session, overlay);
    if (drag_ == Drag::box && glm::distance(cursor_, pressed_at_) > click_slack) overlay.box = {pressed_at_, cursor_};
    draw_gizmo(view, session, overlay);
    const auto centre = gizmo_at(session);
    const auto from = centre ? view.pixel(*centre) : std::nullopt;
    if (!from) return overlay;
    const float metres = axis_length / view.pixels_a_metre(*centre);
    for (int k = 0; k < 3; ++k)
        if (const auto to = view.pixel(*centre + metres * axis_vector(k)))
            overlay.axes.push_back({*from, *to, k, drag_ == Drag::axis && axis_ == k});
    return overlay;
}

void Tools::draw_gizmo(const Viewport& view, const Session& session, Overlay& overlay) const {
    const auto frame = gizmo_frame(session);
    if (!frame || drag_ == Drag::box) return;
    const std::optional<GizmoHandle> strong = held_ ? std::optional(held_->handle()) : over_;
    for (GizmoLine& line : gizmo_shape(gizmo_, *frame, view)) {
        const bool is_strong = strong == line.handle, scales = gizmo_ == GizmoMode::scale;
        if (line.handle.axis == 3)
            overlay.middle = Overlay::Middle{line.points[0], is_strong, scales};
        else if (gizmo_ == GizmoMode::turn)
            overlay.rings.push_back({std::move(line.points), line.handle.axis, is_strong});
        else
            overlay.axes.push_back({line.points[0], line.points[1], line.handle.axis, is_strong, scales});
    }
    if (held_) overlay.text = held_text_;
}

void Tools::remove_selected(Session& session) const {
    if (!session.selected.empty()) return session.remove_selected();
    if (session.sites().selection.empty() || session.broken()) return;
    const uint64_t gesture = session.begin_gesture();
    session.take_sites(gesture);
    session.edit(RemoveSites{session.sites().selection}, gesture);
    session.sites().selection.clear();
}

void Tools::duplicate_selected(Session& session) const {
    if (!session.selected.empty()) return session.duplicate_selected();
    if (session.sites().selection.empty() || session.broken()) return;
    constexpr double beside = 0.08; // m on the stage, so that copies are visible beside the originals
    const uint64_t gesture = session.begin_gesture();
    session.take_sites(gesture);
    const auto first = static_cast<uint32_t>(session.sites().on_stage().size());
    session.edit(DuplicateSites{session.sites().selection, glm::dvec3(beside / session.object().scale(), 0.0, 0.0)},
                 gesture);
    session.sites().selection.clear();
    for (uint32_t s = first; s < session.sites().on_stage().size(); ++s) session.sites().selection.push_back(s);
}

void Tools::mirror_selected(Session& session, int axis) const {
    if (session.broken()) return;
    std::vector<uint32_t> sites = session.sites().selection;
    if (sites.empty())
        for (uint32_t s = 0; s < session.sites().on_stage().size(); ++s) sites.push_back(s);
    const uint64_t gesture = session.begin_gesture();
    session.take_sites(gesture);
    session.edit(MirrorSites{sites, axis, fracture::bounds(session.object().file().model.mesh).centre()[axis]},
                 gesture);
}

} // namespace brittle::tools
