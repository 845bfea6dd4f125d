// Recipes in the C interface.
#include <filesystem>
#include <system_error>

#include "bindings/c/scenario.h"
#include "tools/scenario/recipe/json_reader.h"
#include "tools/scenario/recipe/recipe.h"

using namespace brittle;

namespace brittle::c {

namespace {

brittle_load_settings load_defaults() {
    brittle_load_settings settings{};
    settings.struct_size = sizeof settings;
    return settings;
}

} // namespace

brittle_status status_of(const tools::Failure& failure) {
    if (failure.status()) return status_of(*failure.status());
    switch (failure.code()) {
    case tools::exit_usage:
        return BRITTLE_INVALID_SETTING;
    case tools::exit_input:
        return BRITTLE_MALFORMED_FILE;
    case tools::exit_mesh:
        return BRITTLE_INVALID_MESH;
    case tools::exit_output:
        return BRITTLE_WRITE_FAILED;
    case tools::exit_interrupted:
        return BRITTLE_CANCELLED;
    default:
        return BRITTLE_INTERNAL_ERROR;
    }
}

Caller::Caller(const brittle_load_settings* settings) {
    const brittle_load_settings given = read_settings(settings, load_defaults(), "settings");
    threads = static_cast<uint32_t>(in_range(given.threads, 0, 1024, "settings.threads"));
    void* const user = given.user;
    if (given.progress) progress = [call = given.progress, user](double share) { call(user, share); };
    if (given.report) host.report = [call = given.report, user](const std::string& text) { call(user, text.c_str()); };
    host.cancelled = cancel_question(given.cancelled, user, given.cancel_flag);
}

tools::FractureOptions Caller::options_of(const brittle_recipe& recipe) const {
    tools::FractureOptions options = recipe.options;
    options.threads = threads;
    options.save_recipe.clear();
    return options;
}

std::string read_path(const char* path, const char* name) {
    std::string text = read_text(path, name);
    if (text.empty()) refuse(std::string(name) + " is empty");
    return text;
}

std::string read_file_name(const char* path, const char* name) {
    std::string file = read_path(path, name);
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) refuse(file + ": there is no such file", BRITTLE_FILE_NOT_FOUND);
    return file;
}

} // namespace brittle::c

using c::guarded_run;
using c::need;
using c::refuse;

extern "C" {

void brittle_load_settings_init(brittle_load_settings* settings, size_t struct_size) {
    c::init_struct(settings, struct_size, c::load_defaults());
}

brittle_status brittle_recipe_load(const char* path, brittle_recipe** out, brittle_error* error) {
    return guarded_run(error, [&] {
        need(out, "out");
        auto recipe = std::make_unique<brittle_recipe>();
        tools::read_recipe(c::read_file_name(path, "path"), recipe->options);
        *out = recipe.release();
    });
}

brittle_status brittle_recipe_parse(const char* json, const char* folder, brittle_recipe** out, brittle_error* error) {
    return guarded_run(error, [&] {
        need(out, "out");
        const std::string text = c::read_text(json, "json");
        if (text.size() > tools::max_recipe_bytes) refuse("the recipe exceeds 1 MiB", BRITTLE_MALFORMED_FILE);
        const std::filesystem::path file =
            std::filesystem::path(folder ? c::read_text(folder, "folder") : "") / "recipe";
        const nlohmann::ordered_json parsed = tools::parse_json(file, text, "recipe");
        auto recipe = std::make_unique<brittle_recipe>();
        tools::read_recipe(file, parsed, "", recipe->options);
        *out = recipe.release();
    });
}

brittle_status brittle_recipe_text(const brittle_recipe* recipe, brittle_text** out, brittle_error* error) {
    return guarded_run(error, [&] {
        need(out, "out");
        *out = new brittle_text{tools::recipe_json(need(recipe, "recipe").options)};
    });
}

brittle_status brittle_recipe_save(const brittle_recipe* recipe, const char* path, brittle_error* error) {
    return guarded_run(error, [&] { tools::write_recipe(c::read_path(path, "path"), need(recipe, "recipe").options); });
}

brittle_status brittle_recipe_fracture(const brittle_recipe* recipe, const brittle_load_settings* settings,
                                       brittle_pieces** out, brittle_error* error) {
    return guarded_run(error, [&] {
        need(out, "out");
        const c::Caller caller(settings);
        const tools::FractureOptions options = caller.options_of(need(recipe, "recipe"));
        tools::Input input = tools::load_input(options, true, caller.host);
        tools::Broken broken = tools::break_input(input, options, caller.progress, nullptr, caller.host.cancelled);
        auto pieces = std::make_unique<brittle_pieces>();
        pieces->rough = !broken.rough.is_flat();
        pieces->fragments = std::move(broken.fragments);
        pieces->sites = std::move(input.sites);
        pieces->source = std::make_shared<const fracture::Model>(std::move(input.model));
        *out = pieces.release();
    });
}

void brittle_recipe_free(brittle_recipe* recipe) {
    delete recipe;
}

} // extern "C"
