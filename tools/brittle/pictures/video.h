// A video file made by ffmpeg, which gets the frames as they are drawn. Needs the program `ffmpeg` in PATH
// and no library.
//
//     Video video("fall.mp4", 60.0);
//     video.add(image);            // all of one size
//     video.finish();              // the file is there
//
// Atomic: ffmpeg writes `fall.part.mp4`, which is renamed at the end; without finish() the destructor removes
// it.
#pragma once

#include <filesystem>

#include <sys/types.h>

#include "engine/core/bitmap.h"

namespace brittle::tools {

class Video {
  public:
    // The file's ending says the format: mp4, mkv, webm, gif and what else ffmpeg knows.
    Video(std::filesystem::path file, double frames_per_second);
    ~Video();
    Video(const Video&) = delete;
    Video& operator=(const Video&) = delete;

    // Both throw a Failure: exit_usage where there is no ffmpeg, exit_output where it fails; its own words
    // are on standard error by then.
    void add(const engine::Bitmap& image);
    void finish();

  private:
    void start(const engine::Bitmap& first);
    // Ends the stream and returns whether ffmpeg was content.
    bool close();

    std::filesystem::path file_, part_;
    double frames_per_second_;
    uint32_t width_ = 0, height_ = 0;
    pid_t process_ = -1;
    int stream_ = -1;
};

} // namespace brittle::tools
