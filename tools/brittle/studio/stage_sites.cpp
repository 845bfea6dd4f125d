#include "tools/brittle/studio/stage_sites.h"

#include <set>

namespace brittle::tools {

void StageSites::generate(const FractureOptions& recipe, const Object& object) {
    placed_.clear();
    on_stage_.clear();
    if (object.is_scene()) return; // its objects have sites of their own
    FractureOptions whole = recipe;
    whole.strikes.clear();
    placed_ = placed_sites(sites_for(whole, object.file().model.mesh));
    for (const PlacedSite& site : placed_) on_stage_.push_back(object.to_stage(site.at));
}

std::vector<PlacedSite> StageSites::selected() const {
    std::vector<PlacedSite> sites;
    for (const uint32_t s : selection)
        if (s < placed_.size()) sites.push_back(placed_[s]);
    return sites;
}

std::vector<uint32_t> StageSites::fellows_of_selected() const {
    std::set<uint32_t> groups;
    for (const PlacedSite& site : selected()) groups.insert(site.group);
    groups.erase(0);
    std::vector<uint32_t> fellows;
    for (uint32_t s = 0; s < placed_.size(); ++s)
        if (groups.contains(placed_[s].group)) fellows.push_back(s);
    return fellows;
}

} // namespace brittle::tools
