// The preview on the stage: the cells of the recipe on the whole mesh, and the result of the blow that the hammer is
// aimed at.
//
//     preview.aim(hit->point, direction);
//     each frame: preview.update();
//
// Previews are computed by Preview on a worker, and appear some frames later. The newest one is shown even if the request
// has changed since, because requests come faster than results during a drag.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/render/renderer.h"
#include "engine/render/scene.h"
#include "tools/brittle/studio/object.h"
#include "tools/brittle/studio/piece_view.h"
#include "tools/brittle/studio/preview.h"

namespace brittle::tools {

class Session;

class StagePreview {
  public:
    // Both must outlive the preview.
    StagePreview(const Session& session, engine::Renderer& renderer)
        : session_(session), renderer_(renderer), preview_(renderer) {}

    // Shows the result of the hammer's blow at a point of the whole mesh, until another call.
    void aim(const glm::dvec3& at, const glm::dvec3& direction);
    // Shows the cracks of the hammer's blow at a piece while the piece rests, until another call.
    void aim(const PieceHit& hit, const glm::dvec3& direction);
    void aim_nowhere();

    // Requests and takes over previews. Called once per frame.
    void update();
    // Forgets all previews. Called when the stage shows other pieces.
    void forget();

    // The preview on display in place of the whole mesh, or null.
    [[nodiscard]] const Cracked* shown() const { return shown_.get(); }
    // The preview on display, in place of the mesh or as cracks on a piece, or null.
    [[nodiscard]] const Cracked* current() const { return shown_ ? shown_.get() : cracks_ahead_.get(); }
    [[nodiscard]] uint32_t pieces() const { return current() ? current()->pieces : 0; }
    // Indices of sites without effect; empty while no preview of the sites is shown.
    [[nodiscard]] std::span<const uint32_t> idle_sites() const;
    // Whether the hammer is aimed at the whole mesh.
    [[nodiscard]] bool aims_at_whole() const { return aimed_strike_ || aimed_blow_; }
    // Whether a preview is being made or waits to be taken.
    [[nodiscard]] bool busy() const { return preview_.busy(); }

    // Adds the cracks on the piece that the hammer is aimed at, where the piece is drawn.
    void add_cracks_ahead(std::vector<engine::LineVertex>& lines) const;

    bool wanted = false; // shown for the tool in use, whatever the view's settings
    // A mouse button is down. Changes then ask for coarse previews, and the release for a fine one.
    bool held = false;

  private:
    // The content of a request for the whole mesh.
    struct Request {
        uint64_t version;
        const Object* object;
        std::optional<Strike> strike;
        std::optional<AimedBlow> blow;
        bool coarse = false;

        friend bool operator==(const Request&, const Request&) = default;
    };
    struct AimedPiece {
        PieceHit hit;
        glm::dvec3 direction;
        double radius;

        friend bool operator==(const AimedPiece&, const AimedPiece&) = default;
    };

    void leave();
    void look_ahead();
    void draw_instead(engine::PieceBatch batch);
    [[nodiscard]] bool is_wanted() const;
    [[nodiscard]] bool rests(uint32_t piece) const;
    [[nodiscard]] bool is_fixed(uint32_t piece) const;

    const Session& session_;
    engine::Renderer& renderer_;
    std::optional<Strike> aimed_strike_; // at the whole mesh; at most one of the three is set
    std::optional<AimedBlow> aimed_blow_;
    std::optional<AimedPiece> aimed_piece_;
    std::shared_ptr<Cracked> shown_; // uploaded in place of the whole mesh
    std::optional<Request> asked_;   // the last request
    std::shared_ptr<Cracked> cracks_ahead_;
    std::optional<AimedPiece> asked_ahead_; // the last request for a piece
    uint64_t key_ = 0;
    Preview preview_;
};

} // namespace brittle::tools
