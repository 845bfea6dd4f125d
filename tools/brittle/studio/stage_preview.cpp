#include "tools/brittle/studio/stage_preview.h"

#include <utility>

#include <glm/gtc/quaternion.hpp>

#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/studio/session.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

void StagePreview::aim(const glm::dvec3& at, const glm::dvec3& direction) {
    aim_nowhere();
    if (session_.recipe().world.breakable)
        aimed_blow_ = blow_at(session_.tools, at, direction);
    else
        aimed_strike_ = strike_at(session_.tools, session_.object(), at, direction);
}

void StagePreview::aim(const PieceHit& hit, const glm::dvec3& direction) {
    aim_nowhere();
    aimed_piece_ = {hit, direction, double{session_.tools.hammer_radius}};
}

void StagePreview::aim_nowhere() {
    aimed_strike_.reset();
    aimed_blow_.reset();
    aimed_piece_.reset();
}

void StagePreview::forget() {
    shown_.reset();
    asked_.reset();
    cracks_ahead_.reset();
    asked_ahead_.reset();
}

std::span<const uint32_t> StagePreview::idle_sites() const {
    if (!shown_ || session_.broken() || shown_->sites.size() != session_.sites().on_stage().size()) return {};
    return shown_->idle_sites;
}

bool StagePreview::is_wanted() const {
    if (session_.broken() || session_.object().is_scene()) return false;
    return session_.recipe().picture.cells || wanted || aims_at_whole();
}

void StagePreview::update() {
    if (session_.broken()) {
        look_ahead();
        return;
    }
    if (!is_wanted()) {
        leave();
        return;
    }
    const Document& document = session_.document();
    Request request{document.version(), &session_.object(), aimed_strike_, aimed_blow_};
    if (asked_) request.coarse = asked_->coarse;
    request.coarse = !session_.recipe().rough.is_flat() && held && (request.coarse || asked_ != request);
    if (asked_ != request) {
        asked_ = request;
        preview_.request({.object = session_.shared_object(),
                          .recipe = session_.recipe(),
                          .ghost = aimed_strike_,
                          .blow = aimed_blow_,
                          .coarse = request.coarse,
                          .version = document.version(),
                          .key = ++key_});
    }
    std::shared_ptr<Cracked> made = preview_.take();
    if (!made || made->piece || made->ghost != aims_at_whole() || !made->fault.empty()) return;
    draw_instead(std::move(made->batch));
    shown_ = std::move(made);
}

void StagePreview::leave() {
    asked_.reset();
    (void)preview_.take();
    if (!shown_) return;
    shown_.reset();
    if (!session_.broken()) draw_instead(session_.object().batch());
}

bool StagePreview::rests(uint32_t piece) const {
    const Stage& stage = session_.stage();
    return session_.playback.paused || !session_.playing() || !stage.world().awake(stage.simulation().body_of(piece));
}

bool StagePreview::is_fixed(uint32_t piece) const {
    const Simulation& simulation = session_.stage().simulation();
    return simulation.members()[simulation.member_of(piece)].fixed;
}

// Cracks are shown on a resting piece only: a moving one would be elsewhere by the time of the result.
void StagePreview::look_ahead() {
    const Simulation& simulation = session_.stage().simulation();
    const bool aims = aimed_piece_ && simulation.destruction() && session_.pieces().contains(aimed_piece_->hit.piece)
                      && rests(aimed_piece_->hit.piece) && !is_fixed(aimed_piece_->hit.piece);
    if (!aims) {
        asked_ahead_.reset();
        cracks_ahead_.reset();
        (void)preview_.take();
        return;
    }
    if (asked_ahead_ != aimed_piece_) {
        asked_ahead_ = aimed_piece_;
        const auto cut =
            simulation.foresee(hammer_blow(simulation, aimed_piece_->hit, aimed_piece_->direction, aimed_piece_->radius,
                                           session_.blow_pieces(aimed_piece_->hit.piece)));
        if (cut)
            preview_.request(
                {.object = session_.shared_object(), .cut = cut, .piece = aimed_piece_->hit.piece, .key = ++key_});
        else
            cracks_ahead_.reset();
    }
    if (std::shared_ptr<Cracked> made = preview_.take(); made && made->piece && made->fault.empty())
        cracks_ahead_ = std::move(made);
    if (cracks_ahead_ && cracks_ahead_->piece != aimed_piece_->hit.piece) cracks_ahead_.reset();
}

void StagePreview::add_cracks_ahead(std::vector<engine::LineVertex>& lines) const {
    if (!cracks_ahead_) return;
    const PieceView pieces = session_.pieces();
    if (!pieces.contains(*cracks_ahead_->piece)) return;
    const std::optional<engine::BodyPose> pose = pieces.pose(*cracks_ahead_->piece);
    if (!pose) return;
    for (engine::LineVertex v : cracks_ahead_->cracks) {
        v.position = pose->position + pose->rotation * v.position;
        lines.push_back(v);
    }
}

void StagePreview::draw_instead(engine::PieceBatch batch) {
    must(renderer_.set_pieces({}));
    (void)must(renderer_.add_pieces(std::move(batch)));
}

} // namespace brittle::tools
