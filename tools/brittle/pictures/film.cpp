#include "tools/brittle/pictures/film.h"

#include "engine/core/bitmap.h"
#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/pictures/id_picture.h"
#include "tools/brittle/pictures/picture_name.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

void check_film(const FilmOptions& options) {
    for (const std::string& name : {options.output, options.ids})
        if (!name.empty() && !is_numbered(name) && !is_plain(name))
            throw Failure(exit_usage, "'" + name
                                          + "' is not a name for pictures: give %04d for the frame's number, or no % "
                                            "for one picture of the last frame");
}

Film::Film(engine::Renderer& renderer, const FilmOptions& options, const PictureOptions& picture,
           const ViewOptions& view, const engine::Bounds& mesh)
    : renderer_(renderer), options_(options), picture_(picture), view_(view),
      camera_(picture_camera(picture, mesh, static_cast<float>(view.width) / static_cast<float>(view.height))) {
    if (!options_.video.empty()) video_ = std::make_unique<Video>(options_.video, 1.0 / film_frame_seconds);
}

void Film::watch(Stage& stage) const {
    stage.watch(camera_, static_cast<float>(view_.width) / static_cast<float>(view_.height));
}

void Film::frame(Stage& stage, uint32_t number, bool last) {
    const bool wanted =
        !options_.output.empty() && (is_numbered(options_.output) ? number % options_.every == 0 : last);
    if (!wanted && !video_) return;
    engine::Scene scene = stage.scene();
    scene.camera = camera_;
    scene.smooth = picture_.smooth;
    scene.wireframe = picture_.wireframe;
    const engine::Bitmap image = must(renderer_.render(scene, {view_.width, view_.height}));
    if (video_) video_->add(image);
    if (!wanted) return;
    pictures_.push_back(picture_name(options_.output, number));
    must(engine::write_png(image, pictures_.back()));
    if (!options_.ids.empty()) {
        const engine::IdImage ids = must(renderer_.render_ids(scene, {view_.width, view_.height}));
        ids_.push_back(picture_name(options_.ids, number));
        must(engine::write_png(id_picture(ids), ids_.back()));
    }
}

void Film::finish() {
    if (video_) video_->finish();
}

std::string Film::summary() const {
    std::string text;
    if (!pictures_.empty())
        text = std::to_string(pictures_.size()) + (pictures_.size() == 1 ? " picture, " : " pictures, the last ")
               + pictures_.back();
    if (video_) text += (text.empty() ? "" : ", and ") + options_.video;
    return text;
}

} // namespace brittle::tools
