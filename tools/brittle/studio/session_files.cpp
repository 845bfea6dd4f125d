#include "tools/brittle/studio/session_files.h"

#include <utility>

#include "tools/brittle/stage/loading.h"
#include "tools/brittle/studio/session.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/run/scene.h"

namespace brittle::tools {

namespace {

bool same_mesh(const Input& a, const Input& b) {
    return a.model.mesh.positions == b.model.mesh.positions && a.model.mesh.triangles == b.model.mesh.triangles;
}

} // namespace

void SessionFiles::open(const std::string& path, bool repair) {
    const bool is_recipe = path.ends_with(".json"), from_scene = is_scene(session_.recipe());
    FractureOptions options = session_.recipe();
    if (is_recipe || from_scene) { // nothing of the scene concerns another mesh
        options = {};
        options.threads = session_.recipe().threads;
    }
    if (!is_recipe) {
        options.mesh = path;
        options.repair = repair;
        options.unite = false;
        options.points.clear();
        options.strikes.clear();
    }
    session_.activity_.start("opening " + path, [this, path, options, is_recipe, from_scene,
                                                 repair](const Worker::Cancelled& cancelled) mutable {
        try {
            std::vector<std::string> notes;
            if (is_recipe) {
                read_recipe(path, options);
                notes = expand_level(options);
            }
            auto object = Object::open(options, cancelled);
            session_.activity_.post([this, path, options, object, is_recipe, from_scene, repair, notes] {
                is_recipe || from_scene ? session_.document_.apply(SetRecipe{options})
                                        : session_.document_.apply(SetMesh{path, repair});
                session_.selected.clear();
                session_.forget_marks();
                if (is_recipe || from_scene) session_.recipe_file = is_recipe ? path : std::string();
                session_.due_ = {};
                session_.level_notes_ = notes;
                session_.adopt(object);
                if (is_recipe) {
                    session_.document_.mark_saved();
                    if (opened) opened(path);
                }
            });
        } catch (const Failure& failure) {
            const bool mendable = std::string(failure.what()).find("--repair") != std::string::npos;
            session_.activity_.post(
                [this, failure, mend = mendable ? path : std::string()] { session_.report(failure, mend); });
        }
    });
}

void SessionFiles::save_recipe(const std::filesystem::path& file) {
    try {
        write_recipe(file, session_.recipe());
        session_.document_.mark_saved();
        session_.recipe_file = file.string();
        session_.activity_.say({"saved " + file.string()});
        if (opened) opened(file.string());
    } catch (const Failure& failure) {
        session_.report(failure);
    }
}

void SessionFiles::export_pieces(const std::filesystem::path& file, PiecesAs as) {
    FractureOptions options = session_.recipe();
    options.save_recipe.clear();
    ExportSettings settings = options.exports;
    settings.output = file.string();
    std::vector<std::string> idle; // of a recipe for another format
    settings = effective_export(
        settings, "--output", [](const std::string&) { return false; }, idle);
    try {
        check_export_of_scene(options, settings);
        if (session_.object_->is_scene()) {
            if (!session_.object_->is_prepared()) {
                session_.activity_.say({"The scene is still being prepared. Export it once it is ready.", true});
                return;
            }
            const size_t pieces =
                write_scene_state(settings, as, session_.object_->scene(), session_.stage_->simulation());
            session_.activity_.say({written_text(pieces, {file})});
            return;
        }
    } catch (const Failure& failure) {
        session_.report(failure);
        return;
    }
    std::shared_ptr<const Snapshot> state;
    if (session_.broken() && (session_.stage_->simulation().destruction() || as == PiecesAs::they_lie)) {
        options.world = session_.world_;
        state = std::make_shared<const Snapshot>(snapshot(session_.stage_->simulation(), session_.fragments_));
    } else if (session_.broken()) {
        options.world.breakable = false; // the pieces are those of the first fracture
    }
    session_.activity_.start(
        "writing " + file.string(),
        [this, settings, as, options, state, object = session_.object_](const Worker::Cancelled& cancelled) {
            const Input source = open_input(options, true);
            size_t pieces = 0;
            std::vector<std::filesystem::path> files;
            if (state) {
                if (!same_mesh(source, object->file()))
                    throw Failure(exit_mesh, source.name + " has changed since it was opened: open it again");
                pieces = state->pieces.size();
                files = write_state(settings, as, options, source, *state, cancelled);
            } else {
                const Broken made = break_input(
                    source, options, [this](double share) { session_.activity_.set_share(share); }, nullptr, cancelled);
                pieces = made.fragments.pieces.size();
                files = write_pieces(settings, options, source, made);
            }
            session_.activity_.post([this, text = written_text(pieces, files)] { session_.activity_.say({text}); });
        });
}

void SessionFiles::save_replay(const std::filesystem::path& file) {
    try {
        session_.recorder_->save(file);
        session_.activity_.say({"saved " + file.string() + "; `brittle replay` repeats it"});
    } catch (const Failure& failure) {
        session_.report(failure);
    }
}

void SessionFiles::finish_video(std::shared_ptr<Video> video, const std::string& file) {
    session_.activity_.start("encoding " + file, [this, video = std::move(video), file](const Worker::Cancelled&) {
        video->finish();
        session_.activity_.post([this, file] { session_.activity_.say({"wrote " + file}); });
    });
}

void SessionFiles::record(const std::filesystem::path& file) {
    session_.recorder_.emplace(file, session_.recipe());
    session_.make_stage(); // a scene stands already: it begins again, into this log
}

void SessionFiles::finish_recording() {
    session_.recorder_->finish();
}

} // namespace brittle::tools
