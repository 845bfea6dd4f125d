// A video file encoded by ffmpeg, which receives the frames as they are drawn. Needs the program `ffmpeg` in PATH and
// no library.
//
//     Video video("fall.mp4", 60.0);
//     video.add(image);            // all frames have one size
//     video.finish();              // completes the file
//
// The file is written atomically: ffmpeg writes `fall.part.mp4`, which finish() renames. Without finish() the
// destructor removes it.
#pragma once

#include <filesystem>

#include <sys/types.h>

#include "engine/core/bitmap.h"

namespace brittle::tools {

class Video {
  public:
    // The ending of the file gives the format: mp4, mkv, webm, gif or another one that ffmpeg knows.
    Video(std::filesystem::path file, double frames_per_second);
    ~Video();
    Video(const Video&) = delete;
    Video& operator=(const Video&) = delete;

    // add() and finish() throw a Failure: exit_usage if there is no ffmpeg, exit_output if it fails. ffmpeg's own
    // messages are on standard error by then.
    void add(const engine::Bitmap& image);
    void finish();

  private:
    void start(const engine::Bitmap& first);
    // Ends the stream and returns whether ffmpeg succeeded.
    bool close();

    std::filesystem::path file_, part_;
    double frames_per_second_;
    uint32_t width_ = 0, height_ = 0;
    pid_t process_ = -1;
    int stream_ = -1;
};

} // namespace brittle::tools
