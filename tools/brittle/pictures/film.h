// Draws a stage frame by frame into numbered pictures, one picture of the last frame, or a video. Shared by `brittle
// render` and `brittle replay --render`.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/render/renderer.h"
#include "tools/brittle/pictures/picture.h"
#include "tools/brittle/pictures/video.h"
#include "tools/brittle/stage/stage.h"
#include "tools/scenario/recipe/view_options.h"

namespace brittle::tools {

constexpr double film_frame_seconds = 1.0 / 60.0;

struct FilmOptions {
    std::string output{}; // name of the pictures, with or without %04d for the frame's number; empty: none
    std::string ids{};    // name, in the manner of `output`, of pictures of piece numbers (id_picture.h); empty: none
    uint32_t every = 10;  // interval between frames that become pictures
    std::string video{};  // video file of all frames; empty: none
};

// Throws a Failure with exit_usage if a name of pictures is invalid.
void check_film(const FilmOptions& options);

class Film {
  public:
    // The renderer must outlive the film.
    Film(engine::Renderer& renderer, const FilmOptions& options, const PictureOptions& picture, const ViewOptions& view,
         const engine::Bounds& mesh);

    // Passes the film's camera to the stage, before the stage advances.
    void watch(Stage& stage) const;
    // Draws the outputs that a frame belongs to. Throws a Failure.
    void frame(Stage& stage, uint32_t number, bool last);
    // Completes the video.
    void finish();

    // The files written so far, in order.
    [[nodiscard]] const std::vector<std::string>& pictures() const { return pictures_; }
    [[nodiscard]] const std::vector<std::string>& ids() const { return ids_; }
    // Returns a text for people: "12 pictures, the last fall_0110.png, and fall.mp4".
    [[nodiscard]] std::string summary() const;

  private:
    engine::Renderer& renderer_;
    FilmOptions options_;
    PictureOptions picture_;
    ViewOptions view_;
    engine::Camera camera_;
    std::unique_ptr<Video> video_;
    std::vector<std::string> pictures_, ids_;
};

} // namespace brittle::tools
