#include <cstdio>
#include <filesystem>
#include <span>
#include <vector>

#include "fracture/io/atomic_file.h"
#include "fracture/io/export.h"
#include "fracture/io/import.h"
#include "physics/hull.h"
#include "physics/material.h"
#include "tools/brittle/classify_choice.h"
#include "tools/brittle/commands.h"
#include "tools/brittle/failure.h"
#include "tools/brittle/interrupt.h"
#include "tools/brittle/progress.h"
#include "tools/brittle/recipe.h"
#include "tools/brittle/report.h"
#include "tools/brittle/view.h"

namespace brittle::tools {

namespace {

// Engines add margins of their own, so hardly any is taken off here.
constexpr float least_margin = 0.001f;

fracture::TriangleMesh collision_mesh(const fracture::Fragments& fragments, const fracture::Piece& piece) {
    const glm::dvec3 centre = piece.mass.centre_of_mass;
    const physics::CollisionHull hull =
        physics::collision_hull(fragments.positions_of(piece), centre, {.margin_fraction = least_margin});
    fracture::TriangleMesh mesh = physics::hull_mesh(hull.points);
    for (glm::dvec3& p : mesh.positions) p += centre;
    return mesh;
}

double density(const FractureCommand& command) {
    const physics::MaterialPreset* preset = physics::material_preset(command.fracture.material);
    return command.density > 0.0 ? command.density : (preset ? preset->material.density : physics::Material{}.density);
}

std::vector<std::filesystem::path> export_broken(const FractureCommand& command, const Input& input,
                                                 const Broken& broken, const std::string& recipe) {
    fracture::ExportOptions options{.name = input.name, .recipe = recipe, .source = &input.model, .sites = input.sites};
    options.per_piece = command.per_piece;
    if (const physics::MaterialPreset* preset = physics::material_preset(command.fracture.material)) {
        options.exterior = fracture::Material{
            .name = command.fracture.material, .base_colour = glm::dvec4(preset->exterior, 1.0), .roughness = 0.85};
        options.interior = fracture::Material{
            .name = "interior", .base_colour = glm::dvec4(preset->interior, 1.0), .roughness = 0.95};
    }
    options.hull_names = command.hulls == "unreal" ? fracture::HullNames::unreal : fracture::HullNames::godot;
    options.rigid_bodies = command.rigid_bodies;
    options.density = density(command);
    std::vector<fracture::TriangleMesh> hulls;
    if (!command.hulls.empty() || command.rigid_bodies) {
        for (const fracture::Piece& piece : broken.fragments.pieces)
            hulls.push_back(collision_mesh(broken.fragments, piece));
        options.hulls = hulls;
    }
    if (!command.interior_texture.empty()) options.interior_image = must(fracture::read_image(command.interior_texture));
    return must(fracture::export_pieces(command.output, broken.fragments, broken.certificate, options));
}

} // namespace

int run_fracture(const FractureCommand& command) {
    catch_interrupts();
    const Input input = load_input(command.fracture, true);
    for (const std::string& note : input.model.notes)
        std::fprintf(stderr, "brittle: %s: %s\n", input.name.c_str(), note.c_str());
    const ClassifyPath path = classify_path(command.classify);
    std::unique_ptr<engine::Device> device;
    ClassifyChoice choice;
    if (path != ClassifyPath::cpu) {
        device = open_device({});
        choice = choose_classifier(path, *device, input, command.fracture);
        std::fprintf(stderr, "brittle: classification on the %s\n", choice.why.c_str());
    }
    const Broken broken = [&] {
        Progress progress("fracturing " + input.name);
        return break_input(input, command.fracture, [&](double share) { progress.update(share); },
                           choice.classifier.get());
    }();

    const std::string recipe = recipe_json(command.fracture);
    const auto files = export_broken(command, input, broken, recipe);
    std::printf("%s", report_text(input, broken).c_str());
    if (!files.empty()) std::printf("  written    %s", files.front().c_str());
    std::printf(files.size() > 1 ? " to %s\n" : "\n", files.size() > 1 ? files.back().c_str() : "");
    if (!command.report.empty()) {
        const std::string json = report_json(input, broken, recipe);
        must(fracture::write_file_atomically(command.report, std::as_bytes(std::span(json))));
        std::printf("  report     %s\n", command.report.c_str());
    }
    if (!command.fracture.save_recipe.empty()) std::printf("  recipe     %s\n", command.fracture.save_recipe.c_str());
    if (!broken.certificate.closed) {
        throw Failure(exit_failure, std::to_string(broken.certificate.open_pieces) + " of " +
                                        std::to_string(broken.certificate.pieces) +
                                        " pieces are not closed; please report this mesh with these options");
    }
    return exit_success;
}

} // namespace brittle::tools
