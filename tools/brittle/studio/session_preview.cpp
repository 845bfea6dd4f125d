// What the session shows before it happens: cells of the recipe, and what a blow would do.
#include <utility>

#include <glm/gtc/quaternion.hpp>

#include "tools/brittle/base/failure.h"
#include "tools/brittle/studio/session.h"

namespace brittle::tools {

namespace {

constexpr float hull_lift = 0.01f; // share of the way to the eye by which lines of hulls are drawn before pieces

} // namespace

Strike Session::strike_at(const glm::dvec3& at, const glm::dvec3& direction) const {
    return {object_->to_file(at), direction, tools.hammer_radius / object_->scale(), tools.hammer_pieces};
}

AimedBlow Session::blow_at(const glm::dvec3& at, const glm::dvec3& direction) const {
    return {at, direction, double{tools.hammer_radius}};
}

void Session::aim(const glm::dvec3& at, const glm::dvec3& direction) {
    aim_nowhere();
    if (recipe().world.breakable)
        aimed_blow_ = blow_at(at, direction);
    else
        aimed_strike_ = strike_at(at, direction);
}

void Session::aim(const PieceHit& hit, const glm::dvec3& direction) {
    aim_nowhere();
    aimed_piece_ = {hit, direction, double{tools.hammer_radius}};
}

void Session::aim_nowhere() {
    aimed_strike_.reset();
    aimed_blow_.reset();
    aimed_piece_.reset();
}

bool Session::wants_preview() const {
    return !broken() && (recipe().picture.cells || preview_wanted || aimed_strike_ || aimed_blow_);
}

void Session::update_preview() {
    if (broken()) {
        look_ahead();
        return;
    }
    if (!wants_preview()) {
        leave_preview();
        return;
    }
    const Shown wanted{document_.version(), object_.get(), aimed_strike_, aimed_blow_};
    if (asked_ != wanted) {
        asked_ = wanted;
        preview_.request({.object = object_,
                          .recipe = recipe(),
                          .ghost = aimed_strike_,
                          .blow = aimed_blow_,
                          .version = document_.version(),
                          .key = ++preview_key_});
    }
    std::shared_ptr<Cracked> made = preview_.take();
    // A drag asks faster than answers come: the newest answer is shown even if it is not the last word.
    if (!made || made->piece || made->ghost != (aimed_strike_ || aimed_blow_) || !made->fault.empty()) return;
    draw_instead(std::move(made->batch));
    shown_ = std::move(made);
}

void Session::leave_preview() {
    asked_.reset();
    (void)preview_.take();
    if (!shown_) return;
    shown_.reset();
    if (!broken()) draw_instead(object_->batch());
}

bool Session::rests(uint32_t of) const {
    return playback.paused || !stage_->world().awake(stage_->simulation().body_of(of));
}

// Cracks on the piece that the hammer is over. None while it moves: they would be of another place by then.
void Session::look_ahead() {
    Simulation& simulation = stage_->simulation();
    const bool wanted =
        aimed_piece_ && simulation.destruction() && contains(aimed_piece_->hit.piece) && rests(aimed_piece_->hit.piece);
    if (!wanted) {
        asked_ahead_.reset();
        cracks_ahead_.reset();
        (void)preview_.take();
        return;
    }
    if (asked_ahead_ != aimed_piece_) {
        asked_ahead_ = aimed_piece_;
        const auto cut = simulation.foresee(hammer_blow(simulation, aimed_piece_->hit, aimed_piece_->direction,
                                                        aimed_piece_->radius, recipe().world.blow_pieces));
        if (cut)
            preview_.request({.object = object_, .cut = cut, .piece = aimed_piece_->hit.piece, .key = ++preview_key_});
        else
            cracks_ahead_.reset();
    }
    if (std::shared_ptr<Cracked> made = preview_.take(); made && made->piece && made->fault.empty())
        cracks_ahead_ = std::move(made);
    if (cracks_ahead_ && cracks_ahead_->piece != aimed_piece_->hit.piece) cracks_ahead_.reset();
}

void Session::add_cracks_ahead(std::vector<engine::LineVertex>& lines) const {
    if (!cracks_ahead_ || !contains(*cracks_ahead_->piece)) return;
    const std::optional<engine::BodyPose> pose = pieces().pose(*cracks_ahead_->piece);
    if (!pose) return;
    for (engine::LineVertex v : cracks_ahead_->cracks) {
        v.position = pose->position + pose->rotation * v.position;
        lines.push_back(v);
    }
}

void Session::draw_instead(engine::PieceBatch batch) {
    must(renderer_.set_pieces({}));
    (void)must(renderer_.add_pieces(std::move(batch)));
}

// Lines are to be seen through pieces, as bonds are, or to lie on them: cracks, and of hulls what is in front, which would
// be a tangle otherwise.
void Session::place_lines(engine::Scene& scene) {
    const bool hulls_alone = broken() && recipe().picture.hulls && !bonds;
    if (shown_ || cracks_ahead_ || hulls_alone) scene.lines_on_top = false;
    if (!hulls_alone) return;
    lines_.assign(scene.lines.begin(), scene.lines.end());
    for (engine::LineVertex& v : lines_) v.position += hull_lift * (scene.camera.eye - v.position);
    scene.lines = lines_;
}

} // namespace brittle::tools
