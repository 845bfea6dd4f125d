#include "tools/brittle/studio/video.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <vector>

#include <spawn.h>
#include <sys/wait.h>

#include "tools/brittle/picture_name.h"

extern char** environ;

namespace brittle::tools {

namespace fs = std::filesystem;

namespace {

constexpr uint32_t most_names = 1000;

} // namespace

std::string sequence_names(const std::string& asked) {
    const fs::path path(asked);
    if (path.extension() != ".mp4") return asked;
    return (path.parent_path() / (path.stem().string() + "_%04d.png")).string();
}

std::string unused_name(const std::string& pattern) {
    std::string name;
    for (uint32_t k = 0; k < most_names; ++k) {
        name = picture_name(pattern, k);
        std::error_code error;
        if (!fs::exists(name, error)) break;
    }
    return name;
}

engine::Scene unshifted(engine::Scene scene) {
    scene.camera.shift = glm::vec2(0.0f);
    return scene;
}

std::string encode_video(const std::string& pictures, const std::string& video) {
    const std::string half = video + ".part.mp4";
    const std::vector<std::string> words{"ffmpeg", "-y", "-loglevel", "error", "-framerate", "60", "-i", pictures, "-pix_fmt", "yuv420p", half};
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str())); // which posix_spawnp does not change
    arguments.push_back(nullptr);
    pid_t child = 0;
    if (const int error = posix_spawnp(&child, "ffmpeg", nullptr, nullptr, arguments.data(), environ); error != 0)
        return error == ENOENT ? "the pictures are there, but no video: ffmpeg is not installed" : std::string("ffmpeg: ") + std::strerror(error);
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {}
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        std::error_code gone;
        fs::remove(half, gone);
        return "the pictures are there, but ffmpeg could not make " + video + " of them; it says why on standard error";
    }
    std::error_code error;
    fs::rename(half, video, error);
    return error ? "cannot name the video " + video + ": " + error.message() : std::string();
}

} // namespace brittle::tools
