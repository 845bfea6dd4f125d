// Draws a stage frame by frame into numbered pictures, one picture of the end, or a video: what `brittle
// render` and `brittle replay --render` have in common.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "engine/render/renderer.h"
#include "tools/brittle/pictures/picture.h"
#include "tools/brittle/pictures/video.h"
#include "tools/brittle/recipe/view_options.h"
#include "tools/brittle/run/stage.h"

namespace brittle::tools {

constexpr double film_frame_seconds = 1.0 / 60.0;

struct FilmOptions {
    std::string output{}; // of pictures, with %04d for the frame's number or without; empty: none
    std::string ids{};    // of each picture's piece numbers (id_picture.h), named like output; empty: none
    uint32_t every = 10;  // so many-th frame becomes a picture
    std::string video{};  // a file of all frames; empty: none
};

// Throws a Failure with exit_usage for what is no name of a picture.
void check_film(const FilmOptions& options);

class Film {
  public:
    // The renderer must outlive it.
    Film(engine::Renderer& renderer, const FilmOptions& options, const PictureOptions& picture, const ViewOptions& view,
         const engine::Bounds& mesh);

    // Tells the stage what its pictures show, before it advances.
    void watch(Stage& stage) const;
    // Draws what is wanted of this frame. Throws a Failure.
    void frame(Stage& stage, uint32_t number, bool last);
    // Ends the video.
    void finish();

    [[nodiscard]] uint32_t pictures() const { return pictures_; }
    // "12 pictures, the last fall_0110.png, and fall.mp4".
    [[nodiscard]] std::string summary() const;

  private:
    engine::Renderer& renderer_;
    FilmOptions options_;
    PictureOptions picture_;
    ViewOptions view_;
    engine::Camera camera_;
    std::unique_ptr<Video> video_;
    uint32_t pictures_ = 0;
    std::string last_;
};

} // namespace brittle::tools
