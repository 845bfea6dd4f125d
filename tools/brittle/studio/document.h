// What the studio's window edits: a recipe, every change of which is a command that can be taken back. Knows no window
// and no device; what it holds is what `brittle fracture --recipe` does.
//
//     Document document(options);
//     const uint64_t drag = document.begin_gesture();
//     document.apply(MoveSites{{3}, delta}, drag);      // once a frame, while the mouse moves
//     document.undo();                                   // takes the whole drag back
//     write_recipe(file, document.recipe());
//
// Coordinates are those of the mesh's file. An edit that changes nothing leaves no trace in the history. Edits of the
// mesh, the pattern or the sites take all strikes back: they say how the whole breaks.
//
// Not in the history: how the picture is taken (recipe().picture), which is no edit of the object.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <glm/vec3.hpp>

#include "tools/brittle/recipe/input.h"

namespace brittle::tools {

struct SetMesh {
    std::string mesh; // a file, or shape:NAME; sites, strikes and anchors of the mesh before go
    bool repair = false;
};
struct SetMaterial {
    std::string name; // of a preset, or empty; with its way to break
};
struct SetPattern {
    fracture::Pattern pattern; // takes the place of sites that were placed by hand or read from a file
};
struct SetWorld {
    WorldOptions world;
};
struct SetSites {
    std::vector<PlacedSite> sites; // placed by hand from here on; none: the pattern again
};
struct AddSite {
    glm::dvec3 at;
};
struct MoveSites { // indices that do not exist are skipped, here and below
    std::vector<uint32_t> sites;
    glm::dvec3 by; // m
};
struct RemoveSites { // the last one stays: nothing breaks without a site
    std::vector<uint32_t> sites;
};
struct SetSiteWeight {
    std::vector<uint32_t> sites;
    double weight = 0.0; // m^2
};
struct SetSiteGroup {
    std::vector<uint32_t> sites;
    uint32_t group = 0; // 0: each by itself
};
// What was in a group is so again with its copies or images in it, and not with what they are of; here and below.
struct DuplicateSites { // the copies come last, in the order of the list
    std::vector<uint32_t> sites;
    glm::dvec3 by; // m
};
struct
    MirrorSites { // adds the images of the listed sites in the plane across the axis at this place, but of those in it
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
struct SetRecipe { // as read from a file
    FractureOptions recipe;
};

using Edit = std::variant<SetMesh, SetMaterial, SetPattern, SetWorld, SetSites, AddSite, MoveSites, RemoveSites,
                          SetSiteWeight, SetSiteGroup, DuplicateSites, MirrorSites, AddAnchor, RemoveAnchors, AddStrike,
                          ClearStrikes, SetRecipe>;

// For menus and messages, e.g. "move sites".
[[nodiscard]] std::string_view name_of(const Edit& edit);

class Document {
  public:
    explicit Document(FractureOptions recipe) : recipe_(std::move(recipe)) {}

    [[nodiscard]] const FractureOptions& recipe() const { return recipe_; }

    // Edits of one gesture are taken back together, in so far as nothing came between them.
    [[nodiscard]] uint64_t begin_gesture() { return ++gestures_; }
    // Whether it changed anything. Throws a Failure with exit_usage for a material that does not exist, and for more than
    // max_points sites or max_anchors (recipe.h), and leaves everything as it was. Weights and groups are brought into
    // their limits.
    bool apply(const Edit& edit, uint64_t gesture = 0);

    [[nodiscard]] bool can_undo() const { return !past_.empty(); }
    [[nodiscard]] bool can_redo() const { return !future_.empty(); }
    [[nodiscard]] std::string_view undo_name() const; // of the edit that undo() takes back; empty for none
    [[nodiscard]] std::string_view redo_name() const;
    bool undo();
    bool redo();

    PictureOptions& picture() { return recipe_.picture; }

    // Changes with each edit, undo and redo: what was made for an older one is out of date.
    [[nodiscard]] uint64_t version() const { return version_; }
    [[nodiscard]] bool saved() const { return version_ == saved_version_; }
    void mark_saved() { saved_version_ = version_; }

  private:
    struct Step {
        FractureOptions before; // for redo: after
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
