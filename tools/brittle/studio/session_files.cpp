// What the session reads and writes: meshes, recipes, pieces, logs, videos.
#include <utility>

#include "tools/brittle/base/failure.h"
#include "tools/brittle/recipe/recipe.h"
#include "tools/brittle/run/state_export.h"
#include "tools/brittle/studio/session.h"

namespace brittle::tools {

namespace {

bool same_mesh(const Input& a, const Input& b) {
    return a.model.mesh.positions == b.model.mesh.positions && a.model.mesh.triangles == b.model.mesh.triangles;
}

} // namespace

void Session::open(const std::string& path, bool repair) {
    FractureOptions options = recipe();
    if (!path.ends_with(".json")) {
        options.mesh = path;
        options.repair = repair;
        options.points.clear();
        options.strikes.clear();
    }
    start("opening " + path, [this, path, options, repair](const Worker::Cancelled&) mutable {
        try {
            const bool is_recipe = path.ends_with(".json");
            if (is_recipe) {
                FractureOptions plain;
                plain.threads = options.threads;
                options = plain;
                read_recipe(path, options);
            }
            auto object = Object::load(options);
            post([this, path, options, object, is_recipe, repair] {
                is_recipe ? document_.apply(SetRecipe{options}) : document_.apply(SetMesh{path, repair});
                adopt(object);
                if (is_recipe) {
                    document_.mark_saved();
                    if (opened) opened(path);
                }
            });
        } catch (const Failure& failure) {
            const bool mendable = std::string(failure.what()).find("--repair") != std::string::npos;
            post([this, failure, mend = mendable ? path : std::string()] { report(failure, mend); });
        }
    });
}

void Session::save_recipe(const std::filesystem::path& file) {
    try {
        write_recipe(file, recipe());
        document_.mark_saved();
        say({"saved " + file.string()});
        if (opened) opened(file.string());
    } catch (const Failure& failure) {
        report(failure);
    }
}

// Cut anew, or as they lie: what the simulation holds. Else the recipe's pieces, as `brittle fracture` writes them.
void Session::export_pieces(const std::filesystem::path& file, PiecesAs as) {
    FractureOptions options = recipe();
    options.save_recipe.clear();
    ExportSettings settings = exports;
    settings.output = file.string();
    std::shared_ptr<const Snapshot> state;
    if (broken() && (stage_->simulation().destruction() || as == PiecesAs::they_lie)) {
        options.world = world_;
        state = std::make_shared<const Snapshot>(snapshot(stage_->simulation(), fragments_));
    } else if (broken()) {
        options.world.breakable = false; // it was cut beforehand
    }
    start("writing " + file.string(),
          [this, settings, as, options, state, object = object_](const Worker::Cancelled& cancelled) {
              const Input source = load_input(options, true);
              size_t pieces = 0;
              std::vector<std::filesystem::path> files;
              if (state) {
                  if (!same_mesh(source, object->file()))
                      throw Failure(exit_mesh, source.name + " has changed since it was opened: open it again");
                  pieces = state->pieces.size();
                  files = write_state(settings, as, options, source, *state, cancelled);
              } else {
                  const Broken made = break_input(
                      source, options, [this](double share) { work_share_ = share; }, nullptr, cancelled);
                  pieces = made.fragments.pieces.size();
                  files = write_pieces(settings, options, source, made);
              }
              post([this, text = written_text(pieces, files)] { say({text}); });
          });
}

void Session::save_replay(const std::filesystem::path& file) {
    try {
        recorder_->save(file);
        say({"saved " + file.string() + "; `brittle replay` repeats it"});
    } catch (const Failure& failure) {
        report(failure);
    }
}

void Session::finish_video(std::shared_ptr<Video> video, const std::string& file) {
    start("encoding " + file, [this, video = std::move(video), file](const Worker::Cancelled&) {
        video->finish();
        post([this, file] { say({"wrote " + file}); });
    });
}

void Session::record(const std::filesystem::path& file) {
    recorder_.emplace(file, recipe());
    stage_->simulation().observe(&*recorder_);
}

void Session::finish_recording() {
    recorder_->finish();
}

} // namespace brittle::tools
