#include "tools/brittle/studio/document.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/recipe.h"

namespace brittle::tools {

namespace {

constexpr size_t max_history = 500; // steps; each holds a recipe of some kilobytes

// Returns the indices below `count`, ascending and without duplicates.
std::vector<uint32_t> existing(std::vector<uint32_t> indices, size_t count) {
    std::sort(indices.begin(), indices.end());
    indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
    std::erase_if(indices, [count](uint32_t k) { return k >= count; });
    return indices;
}

// Assigns numbers to the groups of copies: each copied group gets the lowest number that no site has.
class FreshGroups {
  public:
    explicit FreshGroups(const std::vector<PlacedSite>& sites) {
        for (const PlacedSite& site : sites) taken_.insert(site.group);
    }
    [[nodiscard]] uint32_t of(uint32_t group) {
        if (group == 0) return 0;
        const auto [at, is_new] = fresh_.try_emplace(group, 0);
        if (is_new) {
            at->second = 1;
            while (!taken_.insert(at->second).second) ++at->second;
        }
        return at->second;
    }

  private:
    std::set<uint32_t> taken_;
    std::map<uint32_t, uint32_t> fresh_;
};

struct Applier {
    FractureOptions& recipe;

    void operator()(const SetMesh& edit) const {
        recipe.mesh = edit.mesh;
        recipe.repair = edit.repair;
        recipe.unite = false;
        recipe.points.clear();
        recipe.world.anchors.clear();
        recipe.strikes.clear();
    }
    void operator()(const SetUnite& edit) const { recipe.unite = edit.unite; }
    void operator()(const SetMaterial& edit) const {
        if (edit.name.empty()) {
            recipe.material.clear();
            return;
        }
        use_material(edit.name, recipe);
    }
    void operator()(const SetPattern& edit) const {
        if (recipe.rough.grain == grain_of_material(recipe, recipe.pattern.axis))
            recipe.rough.grain = grain_of_material(recipe, edit.pattern.axis);
        recipe.pattern = edit.pattern;
        recipe.sites_file.clear();
        recipe.points.clear();
        recipe.strikes.clear();
    }
    void operator()(const SetRoughness& edit) const { recipe.rough = edit.rough; }
    void operator()(const SetWorld& edit) const { recipe.world = edit.world; }
    void operator()(const SetSites& edit) const {
        recipe.points = edit.sites;
        recipe.sites_file.clear();
        recipe.strikes.clear();
    }
    void operator()(const AddSite& edit) const {
        recipe.points.push_back({edit.at});
        recipe.sites_file.clear();
        recipe.strikes.clear();
    }
    void operator()(const MoveSites& edit) const {
        for (const uint32_t s : existing(edit.sites, recipe.points.size())) recipe.points[s].at += edit.by;
        recipe.strikes.clear();
    }
    void operator()(const RemoveSites& edit) const {
        std::vector<uint32_t> sites = existing(edit.sites, recipe.points.size());
        if (sites.size() == recipe.points.size() && !sites.empty()) sites.pop_back();
        for (size_t k = sites.size(); k-- > 0;) recipe.points.erase(recipe.points.begin() + sites[k]);
        recipe.strikes.clear();
    }
    void operator()(const SetSiteWeight& edit) const {
        for (const uint32_t s : existing(edit.sites, recipe.points.size()))
            recipe.points[s].weight = std::clamp(edit.weight, -max_weight, max_weight);
        recipe.strikes.clear();
    }
    void operator()(const SetSiteGroup& edit) const {
        for (const uint32_t s : existing(edit.sites, recipe.points.size()))
            recipe.points[s].group = std::min(edit.group, max_group);
        recipe.strikes.clear();
    }
    void operator()(const DuplicateSites& edit) const {
        FreshGroups groups(recipe.points);
        for (const uint32_t s : existing(edit.sites, recipe.points.size())) {
            const PlacedSite& site = recipe.points[s];
            recipe.points.push_back(PlacedSite{site.at + edit.by, site.weight, groups.of(site.group)});
        }
        recipe.strikes.clear();
    }
    void operator()(const MirrorSites& edit) const {
        const int axis = std::clamp(edit.axis, 0, 2);
        FreshGroups groups(recipe.points);
        for (const uint32_t s : existing(edit.sites, recipe.points.size())) {
            PlacedSite image = recipe.points[s];
            image.at[axis] = 2.0 * edit.plane - image.at[axis];
            if (image.at == recipe.points[s].at) continue;
            image.group = groups.of(image.group);
            recipe.points.push_back(image);
        }
        recipe.strikes.clear();
    }
    void operator()(const AddAnchor& edit) const { recipe.world.anchors.push_back(edit.anchor); }
    void operator()(const RemoveAnchors& edit) const {
        std::vector<Anchor>& anchors = recipe.world.anchors;
        const std::vector<uint32_t> gone = existing(edit.anchors, anchors.size());
        for (size_t k = gone.size(); k-- > 0;) anchors.erase(anchors.begin() + gone[k]);
    }
    void operator()(const AddStrike& edit) const { recipe.strikes.push_back(edit.strike); }
    void operator()(const ClearStrikes&) const { recipe.strikes.clear(); }
    void operator()(const SetObjects& edit) const {
        if (edit.objects.empty()) return;
        const std::vector<SceneObject> before = std::exchange(recipe.objects, edit.objects);
        std::set<std::string> names;
        for (SceneObject& object : recipe.objects) {
            const std::string name = object.name;
            for (int number = 2; !names.insert(object.name).second; ++number)
                object.name = name + " " + std::to_string(number);
        }
        follow_objects(recipe.glue, before, recipe.objects);
    }
    void operator()(const SetRecipe& edit) const { recipe = edit.recipe; }
};

} // namespace

std::string_view name_of(const Edit& edit) {
    static constexpr std::array<std::string_view, std::variant_size_v<Edit>> names{
        "open a mesh",          "unite parts",   "change the material", "change the pattern", "change the roughness",
        "change the world",     "set the sites", "place a site",        "move sites",         "delete sites",
        "set weights of sites", "group sites",   "duplicate sites",     "mirror sites",       "anchor",
        "remove anchors",       "strike",        "remove strikes",      "change objects",     "open a recipe"};
    return names[edit.index()];
}

bool Document::apply(const Edit& edit, uint64_t gesture) {
    FractureOptions changed = recipe_;
    std::visit(Applier{changed}, edit);
    if (changed.points.size() > max_points)
        throw Failure(exit_usage, "a recipe holds " + std::to_string(max_points)
                                      + " sites at most; write more into a file (--sites)");
    if (changed.world.anchors.size() > max_anchors)
        throw Failure(exit_usage,
                      "a recipe holds " + std::to_string(max_anchors) + " anchors at most; paint with a larger radius");
    if (recipe_json(changed) == recipe_json(recipe_)) return false;
    const bool goes_on = gesture != 0 && !past_.empty() && past_.back().gesture == gesture && future_.empty();
    if (!goes_on) past_.push_back({recipe_, name_of(edit), gesture});
    if (past_.size() > max_history) past_.erase(past_.begin());
    future_.clear();
    recipe_ = std::move(changed);
    ++version_;
    return true;
}

std::string_view Document::undo_name() const {
    return past_.empty() ? std::string_view() : past_.back().name;
}

std::string_view Document::redo_name() const {
    return future_.empty() ? std::string_view() : future_.back().name;
}

void Document::exchange(std::vector<Step>& from, std::vector<Step>& to) {
    Step step = std::move(from.back());
    from.pop_back();
    step.before.picture = recipe_.picture; // pictures and files of pieces are not part of the history
    step.before.exports = recipe_.exports;
    std::swap(step.before, recipe_);
    step.gesture = 0;
    to.push_back(std::move(step));
    ++version_;
}

bool Document::undo() {
    if (past_.empty()) return false;
    exchange(past_, future_);
    return true;
}

bool Document::redo() {
    if (future_.empty()) return false;
    exchange(future_, past_);
    return true;
}

} // namespace brittle::tools
