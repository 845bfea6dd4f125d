#include "tools/brittle/commands/report.h"

#include <algorithm>
#include <cinttypes>
#include <cstdarg>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "fracture/io/certificate_json.h"
#include "tools/brittle/base/console.h"
#include "tools/scenario/recipe/json_reader.h"
#include "tools/scenario/recipe/recipe.h"

namespace brittle::tools {

namespace {

[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
    char buffer[512];
    va_list arguments;
    va_start(arguments, pattern);
    std::vsnprintf(buffer, sizeof buffer, pattern, arguments);
    va_end(arguments);
    return buffer;
}

std::string number_of(size_t count, const char* one, const char* many) {
    return std::to_string(count) + (count == 1 ? one : many);
}

// Says why the pieces are not as many as the sites; empty where they are, or where groups join cells.
std::string difference(const Input& input, const Broken& broken) {
    const fracture::Certificate& c = broken.certificate;
    if (c.pieces == input.sites.size() || !input.groups.empty()) return {};
    std::string text;
    if (c.cells < input.sites.size())
        text = number_of(input.sites.size() - c.cells, " site has", " sites have")
               + " no piece of their own: cells that miss the solid, or pieces below the minimum volume";
    if (c.pieces > c.cells)
        text += (text.empty() ? "" : "; ") + number_of(c.pieces - c.cells, " piece more", " pieces more")
                + " than cells, because the solid falls apart inside a cell";
    return text.empty() ? text : "             " + text + "\n";
}

} // namespace

std::string report_text(const Input& input, const Broken& broken) {
    const fracture::Certificate& c = broken.certificate;
    std::string text;
    text += format("%s: %" PRIu64 " triangles, %zu sites\n", input.name.c_str(), c.triangles_in, input.sites.size());
    text += format("  pieces     %u in %u cells, %s\n", c.pieces, c.cells,
                   c.closed ? "every one closed and oriented" : format("%u NOT CLOSED", c.open_pieces).c_str());
    text += difference(input, broken);
    text +=
        format("  volume     %.9g in, %.9g out, relative error %.1e\n", c.volume_input, c.volume_sum, c.volume_error);
    text += format("  smallest   %.3g of the volume\n", c.smallest_piece / c.volume_input);
    text +=
        format("  triangles  %" PRIu64 " out, %" PRIu64 " of them on cut faces\n", c.triangles_out, c.cap_triangles);
    if (!broken.rough.is_flat())
        text += format("  roughness  %.3g, detail %u: %" PRIu64 " of the triangles were added for it\n",
                       broken.rough.amount, broken.rough.detail, broken.fragments.rough_triangles);
    if (broken.fragments.crossings > 0)
        text += format("  crossings  %u triangles of rough cuts cross their piece; choose less --roughness\n",
                       broken.fragments.crossings);
    text += format("  time       %.1f ms", broken.milliseconds);
    for (const fracture::Milliseconds& t : broken.fragments.timings) {
        text += format(", %s %.1f", t.phase.c_str(), t.milliseconds);
    }
    text += format("\n  hash       %016" PRIx64 "\n", c.hash);
    return text;
}

std::string report_json(const Input& input, const Broken& broken, const std::string& recipe) {
    const fracture::Certificate& c = broken.certificate;
    nlohmann::ordered_json milliseconds;
    milliseconds["import"] = input.import_milliseconds;
    for (const fracture::Milliseconds& t : broken.fragments.timings) milliseconds[t.phase] = t.milliseconds;
    milliseconds["total"] = broken.milliseconds;
    nlohmann::ordered_json report{{"mesh", input.name}, {"sites", input.sites.size()}};
    report.update(nlohmann::ordered_json::parse(fracture::certificate_json(c)));
    report["islands"] = c.pieces - c.cells;
    report["roughness"] = broken.rough.amount;
    report["rough_triangles"] = broken.fragments.rough_triangles;
    report["crossings"] = broken.fragments.crossings;
    report["milliseconds"] = milliseconds;
    report["recipe"] = nlohmann::ordered_json::parse(recipe);
    return text_of(report, 2) + "\n";
}

SceneCertificate certify(std::span<const BrokenObject> objects) {
    SceneCertificate all;
    for (const BrokenObject& object : objects) {
        if (!object.certificate) continue;
        const fracture::Certificate& c = *object.certificate;
        ++all.objects;
        all.pieces += c.pieces;
        all.open_pieces += c.open_pieces;
        all.volume_input += c.volume_input;
        all.volume_sum += c.volume_sum;
        all.max_volume_error = std::max(all.max_volume_error, c.volume_error);
    }
    return all;
}

std::string report_text(const LoadedScene& scene, std::span<const BrokenObject> objects) {
    const SceneCertificate all = certify(objects);
    size_t triangles = 0, sites = 0, triangles_out = 0;
    double milliseconds = 0.0;
    for (size_t k = 0; k < objects.size(); ++k) {
        triangles += scene.objects[k].input->model.mesh.triangles.size();
        sites += scene.objects[k].input->sites.size();
        triangles_out += objects[k].fragments.triangles.size();
        milliseconds += objects[k].milliseconds;
    }
    const size_t fixed = objects.size() - all.objects;
    std::string text = format("scene: %s, %zu triangles, %zu sites\n",
                              number_of(objects.size(), " object", " objects").c_str(), triangles, sites);
    text += format("  pieces     %zu of %s, %s%s\n", all.pieces, number_of(all.objects, " object", " objects").c_str(),
                   all.open_pieces == 0 ? "every one closed and oriented"
                                        : format("%zu NOT CLOSED", all.open_pieces).c_str(),
                   fixed == 0 ? "" : format("; %zu fixed and whole", fixed).c_str());
    text += format("  volume     %.9g in, %.9g out, relative error of an object %.1e at most\n", all.volume_input,
                   all.volume_sum, all.max_volume_error);
    text += format("  triangles  %zu out\n", triangles_out);
    return text + format("  time       %.1f ms, all objects added up\n", milliseconds);
}

std::string report_json(const LoadedScene& scene, std::span<const BrokenObject> objects, const std::string& recipe) {
    const SceneCertificate all = certify(objects);
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    double milliseconds = 0.0;
    for (size_t k = 0; k < objects.size(); ++k) {
        nlohmann::ordered_json& object = list.emplace_back();
        object["name"] = scene.objects[k].object.name;
        object["fixed"] = scene.objects[k].object.fixed;
        object["sites"] = scene.objects[k].input->sites.size();
        object["milliseconds"] = objects[k].milliseconds;
        if (objects[k].certificate)
            object.update(nlohmann::ordered_json::parse(fracture::certificate_json(*objects[k].certificate)));
        milliseconds += objects[k].milliseconds;
    }
    const nlohmann::ordered_json report{{"objects", list},
                                        {"pieces", all.pieces},
                                        {"open_pieces", all.open_pieces},
                                        {"closed", all.open_pieces == 0},
                                        {"max_volume_error", all.max_volume_error},
                                        {"milliseconds", milliseconds},
                                        {"recipe", nlohmann::ordered_json::parse(recipe)}};
    return text_of(report, 2) + "\n";
}

void print_idle_note(const FractureOptions& scene) {
    FractureOptions rest = scene, plain;
    rest.level = {};
    rest.objects.clear();
    for (FractureOptions* options : {&rest, &plain}) {
        options->units = {};
        options->picture = {};
        options->exports = {};
        WorldOptions& world = options->world;
        world.engine = {};
        world.air_density = 0.0;
        world.max_colliding = world.piece_limit = 0;
        world.shots.clear();
        world.joints.clear();
    }
    if (recipe_json(rest) != recipe_json(plain))
        tell("options of one mesh, such as --material and --pieces, have no effect on a scene; its recipe has them for "
             "each object");
}

void print_split_note(const ExportSettings& settings, const std::vector<std::filesystem::path>& files) {
    if (settings.per_piece || files.size() < 2) return;
    tell("%s: STL does not tell pieces apart, so each piece has a file of its own; --one-file joins them",
         settings.output.c_str());
}

} // namespace brittle::tools
