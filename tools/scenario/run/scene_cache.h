// What load_scene() and prepare_scene() made of the last versions of a scene, so that an edit makes only what changed.
//
//     SceneCache cache;                                        // lives as long as the scene is edited
//     LoadedScene scene = load_scene(options, host, &cache);
//     std::vector<PreparedObject> objects = prepare_scene(scene, host, {}, {}, &cache);
//
// The keys hold all that a mesh, or a prepared object, depends on, and the versions of its files on disk. Results equal
// those without a cache, and share meshes, fragments and solids with earlier results. For one load at a time.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tools/scenario/recipe/input.h"
#include "tools/scenario/run/mesh_files.h"
#include "tools/scenario/run/prepared_object.h"

namespace brittle::tools {

// A map that forgets what has not been used for some rounds.
template<class Key, class Value>
class RecentMap {
  public:
    // Null for an unknown key. Valid until the next end_round().
    [[nodiscard]] Value* find(const Key& key) {
        const auto at = entries_.find(key);
        if (at == entries_.end()) return nullptr;
        at->second.round = round_;
        return &at->second.value;
    }
    Value& add(const Key& key, Value value) {
        return entries_.insert_or_assign(key, Entry{std::move(value), round_}).first->second.value;
    }
    void end_round() {
        ++round_;
        std::erase_if(entries_, [this](const auto& entry) { return entry.second.round + kept_rounds < round_; });
    }
    [[nodiscard]] size_t size() const { return entries_.size(); }

  private:
    static constexpr uint64_t kept_rounds = 8; // so many edits are undone without making anything again
    struct Entry {
        Value value;
        uint64_t round;
    };
    std::map<Key, Entry> entries_;
    uint64_t round_ = 0;
};

struct LoadedMesh {
    std::shared_ptr<const Input> input;
    std::shared_ptr<const std::vector<fracture::Image>> images; // LoadedObject::images
    std::string fault;                                          // why the mesh cannot be broken
};

// An object as prepare_scene() makes it, without payloads.
struct PreparedOnce {
    PreparedObject object;
    std::string fault; // why it cannot be cut, so that it is fixed
};

struct SceneCache {
    MeshFiles files{};
    RecentMap<std::string, LoadedMesh> meshes{};
    RecentMap<std::pair<std::shared_ptr<const Input>, std::string>, PreparedOnce> prepared{};
};

} // namespace brittle::tools
