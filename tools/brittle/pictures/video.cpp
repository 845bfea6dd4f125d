#include "tools/brittle/pictures/video.h"

#include <cassert>
#include <cerrno>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tools/scenario/base/failure.h"

namespace brittle::tools {

namespace {

std::filesystem::path part_of(const std::filesystem::path& file) {
    std::filesystem::path part = file;
    return part.replace_extension(".part" + file.extension().string());
}

} // namespace

Video::Video(std::filesystem::path file, double frames_per_second)
    : file_(std::move(file)), part_(part_of(file_)), frames_per_second_(frames_per_second) {}

Video::~Video() {
    if (process_ < 0) return;
    close();
    std::error_code ignored;
    std::filesystem::remove(part_, ignored);
}

void Video::start(const engine::Bitmap& first) {
    width_ = first.width;
    height_ = first.height;
    // A socket instead of a pipe: MSG_NOSIGNAL suppresses the signal for writing to a closed socket.
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
        throw Failure(exit_failure, std::string("cannot open a socket to ffmpeg: ") + std::strerror(errno));
    std::vector<std::string> words{"ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format", "rgba",
                                   "-video_size", std::to_string(width_) + "x" + std::to_string(height_), "-framerate",
                                   std::to_string(frames_per_second_), "-i", "-",
                                   // Players expect chroma at half resolution, which needs an even width and height.
                                   "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p",
                                   "file:" + part_.string()};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, ends[0], STDIN_FILENO);
    // A process group of its own keeps Ctrl+C from ffmpeg: this program handles it and then ends the stream.
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    const int error = posix_spawnp(&process_, "ffmpeg", &files, &attributes, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    ::close(ends[0]);
    stream_ = ends[1];
    if (error == 0) return;
    ::close(stream_);
    process_ = -1;
    if (error == ENOENT)
        throw Failure(exit_usage,
                      "a video needs the program ffmpeg, which is not installed (Debian: apt install ffmpeg); "
                      "without it write pictures, -o frame_%04d.png");
    throw Failure(exit_failure, std::string("cannot start ffmpeg: ") + std::strerror(error));
}

void Video::add(const engine::Bitmap& image) {
    if (process_ < 0) start(image);
    assert(image.width == width_ && image.height == height_);
    for (size_t sent = 0; sent < image.pixels.size();) {
        const ssize_t count = send(stream_, image.pixels.data() + sent, image.pixels.size() - sent, MSG_NOSIGNAL);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) throw Failure(exit_output, file_.string() + ": ffmpeg stopped reading frames");
        sent += static_cast<size_t>(count);
    }
}

bool Video::close() {
    ::close(stream_);
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = -1;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

void Video::finish() {
    if (process_ < 0) return;
    std::error_code error;
    if (!close()) {
        std::filesystem::remove(part_, error);
        throw Failure(exit_output, file_.string() + ": ffmpeg could not write the video");
    }
    std::filesystem::rename(part_, file_, error);
    if (error) throw Failure(exit_output, file_.string() + ": cannot rename the finished video: " + error.message());
}

} // namespace brittle::tools
