// The files of a session: it opens meshes and recipes, and writes recipes, pieces, replay logs and videos. Results and
// failures become messages of Session::activity().
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "tools/brittle/pictures/video.h"
#include "tools/scenario/recipe/piece_export.h"
#include "tools/scenario/run/state_export.h"

namespace brittle::tools {

class Session;

class SessionFiles {
  public:
    // A part of the session, whose state it reads and replaces.
    explicit SessionFiles(Session& session) : session_(session) {}

    // Opens a mesh, shape:NAME or a recipe, on a worker.
    void open(const std::string& path, bool repair = false);
    void save_recipe(const std::filesystem::path& file);
    // Writes pieces by the settings of Session::exports(), on a worker: the pieces on the stage once the mesh is broken. Before
    // that, and for PiecesAs::made in a world that is not breakable, the recipe's pieces as `brittle fracture` writes
    // them.
    void export_pieces(const std::filesystem::path& file, PiecesAs as = PiecesAs::made);
    // Writes the log of the run since the break (docs/replay.md).
    void save_replay(const std::filesystem::path& file);
    // Completes a video, on a worker.
    void finish_video(std::shared_ptr<Video> video, const std::string& file);

    // Names a file for the replay log of the last break. The log itself is always kept in memory, with some 100 bytes per
    // step and 4 per moving body.
    void record(const std::filesystem::path& file);
    // Writes the log; no effect without record().
    void finish_recording();

    std::function<void(const std::string&)> opened; // called for each opened mesh and each opened or saved recipe

  private:
    Session& session_;
};

} // namespace brittle::tools
