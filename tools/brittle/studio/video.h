// Pictures into files of the studio: their names, and a video of them where ffmpeg is installed.
#pragma once

#include <string>

#include "engine/render/scene.h"

namespace brittle::tools {

// Names of the pictures for what was asked for: of a video those beside it, of anything else itself.
[[nodiscard]] std::string sequence_names(const std::string& asked);
// The first name of a numbered pattern that no file has; with the last number where all are taken.
[[nodiscard]] std::string unused_name(const std::string& pattern);
// For a picture without panels: the scene in its middle.
[[nodiscard]] engine::Scene unshifted(engine::Scene scene);

// Waits for ffmpeg; what is wrong, or an empty string. An old video is replaced once the new one is whole.
[[nodiscard]] std::string encode_video(const std::string& pictures, const std::string& video);

} // namespace brittle::tools
