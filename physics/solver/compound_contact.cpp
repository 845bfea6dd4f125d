#include "physics/solver/compound_contact.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <BulletCollision/BroadphaseCollision/btDbvt.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <btBulletDynamicsCommon.h>

#include "physics/solver/narrow_phase.h"

namespace brittle::physics {

namespace {

struct Box {
    btVector3 low, high;
};

Box box_of(const btCollisionShape& shape, const btTransform& frame) {
    Box box;
    shape.getAabb(frame, box.low, box.high);
    return box;
}

class CompoundPair final : public FollowedContacts {
  public:
    CompoundPair(const btCollisionAlgorithmConstructionInfo& info, const btCollisionObject* compound,
                 const btCollisionObject*)
        : FollowedContacts(info), compound_(compound) {}
    ~CompoundPair() override {
        for (const Child& child : children_) free(child);
    }

    void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                          const btDispatcherInfo& info, btManifoldResult* result) override {
        const Sides sides = sides_of(*first, *second);
        if (!std::exchange(refreshed_, false)) refresh(*result);
        for (const int index : find_near(sides)) {
            Child* child = child_of(index);
            if (!child) child = &*children_.insert(place_of(index), make(sides, index));
            if (!std::exchange(child->followed, false))
                with_child(sides, index, *result, [&](const btCollisionObjectWrapper& hull) {
                    child->contacts->processCollision(&hull, &sides.other, info, result);
                });
        }
        std::erase_if(children_, [&](const Child& child) {
            if (is_near(sides, child.index)) return false;
            free(child);
            return true;
        });
    }

    bool follow(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                const btDispatcherInfo& info, btManifoldResult& result) override {
        const Sides sides = sides_of(first, second);
        const std::vector<int>& near = find_near(sides);
        if (!std::ranges::all_of(near, [&](int index) { return child_of(index); })) return false;
        // Where there are no others, all are near.
        if (children_.size() > near.size()
            && !std::ranges::all_of(children_, [&](const Child& child) { return is_near(sides, child.index); }))
            return false;
        refresh(result);
        bool all = true;
        for (const int index : near)
            with_child(sides, index, result, [&](const btCollisionObjectWrapper& hull) {
                Child& child = *child_of(index);
                child.followed = child.contacts->follow(hull, sides.other, info, result);
                all = all && child.followed;
            });
        refreshed_ = !all; // the rest is to be done in this step
        if (all)
            for (Child& child : children_) child.followed = false;
        return all;
    }

    // Only asked for objects that sweep; ours do not.
    btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                   btManifoldResult*) override {
        return 1.0f;
    }
    void refresh(btManifoldResult& result) override {
        for (const Child& child : children_) child.contacts->refresh(result);
    }
    void collect(std::vector<AnyManifold>& to) override {
        for (const Child& child : children_) child.contacts->collect(to);
    }
    void getAllContactManifolds(btManifoldArray& manifolds) override {
        for (const Child& child : children_) child.contacts->getAllContactManifolds(manifolds);
    }

  private:
    struct Child {
        int index;
        FollowedContacts* contacts;
        bool followed = false; // in this step, in which another child could not be
    };
    struct Sides {
        const btCollisionObjectWrapper& compound;
        const btCollisionObjectWrapper& other;
        Box box; // of the other one
    };

    [[nodiscard]] Sides sides_of(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second) const {
        const bool swapped = first.getCollisionObject() != compound_;
        const btCollisionObjectWrapper& other = swapped ? first : second;
        return {swapped ? second : first, other, box_of(*other.getCollisionShape(), other.getWorldTransform())};
    }
    static const btCompoundShape& shape_of(const Sides& sides) {
        return static_cast<const btCompoundShape&>(*sides.compound.getCollisionShape());
    }
    static btTransform frame_of(const Sides& sides, int index) {
        return sides.compound.getWorldTransform() * shape_of(sides).getChildTransform(index);
    }

    [[nodiscard]] std::vector<Child>::iterator place_of(int index) {
        return std::ranges::lower_bound(children_, index, {}, &Child::index);
    }
    [[nodiscard]] Child* child_of(int index) {
        const auto at = place_of(index);
        return at != children_.end() && at->index == index ? &*at : nullptr;
    }

    static bool is_near(const Sides& sides, int index) {
        const Box box = box_of(*shape_of(sides).getChildShape(index), frame_of(sides, index));
        return TestAabbAgainstAabb2(box.low, box.high, sides.box.low, sides.box.high);
    }

    // In the order of the tree, as Bullet goes through them: manifolds come and go in it. Valid until the thread's next call.
    static std::vector<int>& find_near(const Sides& sides) {
        struct Leaves final : btDbvt::ICollide {
            std::vector<int>& found;
            explicit Leaves(std::vector<int>& to) : found(to) {}
            void Process(const btDbvtNode* leaf) override { found.push_back(leaf->dataAsInt); }
        };
        thread_local std::vector<int> near;
        thread_local btNodeStack stack;
        near.clear();
        const Box box = box_of(*sides.other.getCollisionShape(),
                               sides.compound.getWorldTransform().inverse() * sides.other.getWorldTransform());
        Leaves leaves(near);
        const btDbvt& tree = *shape_of(sides).getDynamicAabbTree();
        tree.collideTVNoStackAlloc(tree.m_root, btDbvtVolume::FromMM(box.low, box.high), stack, leaves);
        std::erase_if(near, [&](int index) { return !is_near(sides, index); });
        return near;
    }

    // Calls with a hull of the compound; contacts that are found meanwhile are of that one.
    static void with_child(const Sides& sides, int index, btManifoldResult& result, const auto& call) {
        const btTransform frame = frame_of(sides, index);
        const btCollisionObjectWrapper hull(&sides.compound, shape_of(sides).getChildShape(index),
                                            sides.compound.getCollisionObject(), frame, -1, index);
        if (result.getBody0Internal() == sides.compound.getCollisionObject()) {
            const btCollisionObjectWrapper* const whole = result.getBody0Wrap();
            result.setBody0Wrap(&hull);
            result.setShapeIdentifiersA(-1, index);
            call(hull);
            result.setBody0Wrap(whole);
        } else {
            const btCollisionObjectWrapper* const whole = result.getBody1Wrap();
            result.setBody1Wrap(&hull);
            result.setShapeIdentifiersB(-1, index);
            call(hull);
            result.setBody1Wrap(whole);
        }
    }

    [[nodiscard]] Child make(const Sides& sides, int index) const {
        const btTransform frame = frame_of(sides, index); // the wrapper keeps a reference
        const btCollisionObjectWrapper hull(&sides.compound, shape_of(sides).getChildShape(index),
                                            sides.compound.getCollisionObject(), frame, -1, index);
        btCollisionAlgorithm* const made =
            m_dispatcher->findAlgorithm(&hull, &sides.other, nullptr, BT_CONTACT_POINT_ALGORITHMS);
        return {index, static_cast<FollowedContacts*>(made)};
    }
    void free(const Child& child) const {
        child.contacts->~FollowedContacts();
        m_dispatcher->freeCollisionAlgorithm(child.contacts);
    }

    const btCollisionObject* compound_;
    std::vector<Child> children_; // by index: of the hulls that are near, or were until now
    bool refreshed_ = false;      // in this step, in which a child could not be followed
};

} // namespace

struct CompoundContacts::Impl {
    CreateContacts<CompoundPair> compound_first{false}, other_first{true};
};

CompoundContacts::CompoundContacts(btCollisionDispatcher& dispatcher) : impl_(std::make_unique<Impl>()) {
    for (const int other : {CONVEX_HULL_SHAPE_PROXYTYPE, STATIC_PLANE_PROXYTYPE}) {
        dispatcher.registerCollisionCreateFunc(COMPOUND_SHAPE_PROXYTYPE, other, &impl_->compound_first);
        dispatcher.registerCollisionCreateFunc(other, COMPOUND_SHAPE_PROXYTYPE, &impl_->other_first);
    }
}
CompoundContacts::~CompoundContacts() = default;

int CompoundContacts::pair_size() {
    return static_cast<int>(sizeof(CompoundPair));
}

} // namespace brittle::physics
