// The document of the studio: a recipe with undo and redo. Each change is an edit, which is a command that can be
// undone. Independent of window and device; the document is what `brittle fracture --recipe` reads.
//
//     Document document(options);
//     const uint64_t drag = document.begin_gesture();
//     document.apply(MoveSites{{3}, delta}, drag);      // once a frame, while the mouse moves
//     document.undo();                                   // undoes the whole drag
//     write_recipe(file, document.recipe());
//
// Coordinates are those of the mesh's file. An edit without effect leaves no trace in the history. Edits of the mesh,
// the pattern or the sites remove all strikes, because those edits decide how the whole mesh breaks.
//
// The picture (recipe().picture) is not part of the history, because it is no property of the object.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <glm/vec3.hpp>

#include "tools/scenario/recipe/input.h"

namespace brittle::tools {

struct SetMesh {
    std::string mesh; // a file, or shape:NAME; sites placed by hand, strikes and anchors are removed
    bool repair = false;
};
struct SetUnite {
    bool unite = false; // parts that pass through each other
};
struct SetMaterial {
    std::string name; // name of a preset, or empty; also sets the preset's fracture pattern and roughness
};
struct SetPattern {
    fracture::Pattern pattern; // replaces sites that were placed by hand or read from a file
};
struct SetRoughness {
    fracture::Roughness rough; // in metres of the file; its seed is ignored
};
struct SetWorld {
    WorldOptions world;
};
struct SetSites {
    std::vector<PlacedSite> sites; // sites that replace the pattern; empty: the pattern again
};
struct AddSite {
    glm::dvec3 at;
};
// Indices that do not exist are skipped, here and below.
struct MoveSites {
    std::vector<uint32_t> sites;
    glm::dvec3 by; // m
};
// The last site stays: a fracture needs one.
struct RemoveSites {
    std::vector<uint32_t> sites;
};
struct SetSiteWeight {
    std::vector<uint32_t> sites;
    double weight = 0.0; // m^2
};
struct SetSiteGroup {
    std::vector<uint32_t> sites;
    uint32_t group = 0; // 0: a piece of its own
};
// Appends copies of the listed sites, in the order of the list. Copies (and images, below) of sites in one group form a
// group of their own.
struct DuplicateSites {
    std::vector<uint32_t> sites;
    glm::dvec3 by; // m
};
// Appends the images of the listed sites, mirrored in the plane across the axis, except for sites in the plane.
struct MirrorSites {
    std::vector<uint32_t> sites;
    int axis = 0;       // 0, 1, 2
    double plane = 0.0; // m
};
struct AddAnchor {
    Anchor anchor;
};
struct RemoveAnchors { // indices
    std::vector<uint32_t> anchors;
};
struct AddStrike {
    Strike strike;
};
struct ClearStrikes {};
// Replaces the objects of a scene: any change of them. An empty list is no change, because a scene needs an object; a
// name that an earlier object has gets a number.
struct SetObjects {
    std::vector<SceneObject> objects;
};
// Replaces the whole recipe, as after reading a file.
struct SetRecipe {
    FractureOptions recipe;
};

using Edit = std::variant<SetMesh, SetUnite, SetMaterial, SetPattern, SetRoughness, SetWorld, SetSites, AddSite,
                          MoveSites, RemoveSites, SetSiteWeight, SetSiteGroup, DuplicateSites, MirrorSites, AddAnchor,
                          RemoveAnchors, AddStrike, ClearStrikes, SetObjects, SetRecipe>;

// Returns the name of an edit for menus and messages, e.g. "move sites".
[[nodiscard]] std::string_view name_of(const Edit& edit);

class Document {
  public:
    explicit Document(FractureOptions recipe) : recipe_(std::move(recipe)) {}

    [[nodiscard]] const FractureOptions& recipe() const { return recipe_; }

    // Returns the number of a new gesture. Consecutive edits of one gesture are undone together.
    [[nodiscard]] uint64_t begin_gesture() { return ++gestures_; }
    // Applies an edit and returns whether it changed anything. Throws a Failure with exit_usage, without any change,
    // for an unknown material, for more than max_points sites and for more than max_anchors anchors (recipe.h). Weights
    // and groups are clamped to their limits.
    bool apply(const Edit& edit, uint64_t gesture = 0);

    [[nodiscard]] bool can_undo() const { return !past_.empty(); }
    [[nodiscard]] bool can_redo() const { return !future_.empty(); }
    [[nodiscard]] std::string_view undo_name() const; // name of the edit that undo() would undo; empty for none
    [[nodiscard]] std::string_view redo_name() const;
    bool undo();
    bool redo();

    PictureOptions& picture() { return recipe_.picture; }
    ExportSettings& exports() { return recipe_.exports; } // without the output

    // Changes with each edit, undo and redo, so that results for an older version can be recognised.
    [[nodiscard]] uint64_t version() const { return version_; }
    [[nodiscard]] bool saved() const { return version_ == saved_version_; }
    void mark_saved() { saved_version_ = version_; }

  private:
    struct Step {
        FractureOptions before; // recipe before the edit; in future_: after it
        std::string_view name;
        uint64_t gesture;
    };
    void exchange(std::vector<Step>& from, std::vector<Step>& to);

    FractureOptions recipe_;
    std::vector<Step> past_, future_;
    uint64_t gestures_ = 0;
    uint64_t version_ = 0;
    uint64_t saved_version_ = 0;
};

} // namespace brittle::tools
