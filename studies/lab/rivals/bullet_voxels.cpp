#include "rivals/bullet_voxels.hpp"

#include <btBulletCollisionCommon.h>

namespace maille::lab {

namespace {

/// One compound of boxes, with the tree that Bullet keeps over its parts.
class Compound {
public:
  explicit Compound(const std::vector<Vec3>& centres) : compound_(true, static_cast<int>(centres.size())) {
    btTransform at;
    at.setIdentity();
    for (const Vec3& c : centres) {
      at.setOrigin({static_cast<btScalar>(c[0]), static_cast<btScalar>(c[1]), static_cast<btScalar>(c[2])});
      compound_.addChildShape(at, &box_);
    }
    object_.setCollisionShape(&compound_);
  }
  btCollisionObject& object() { return object_; }

private:
  btBoxShape box_{btVector3(0.5, 0.5, 0.5)};
  btCompoundShape compound_;
  btCollisionObject object_;
};

struct AnyContact : btCollisionWorld::ContactResultCallback {
  bool found = false;
  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                           const btCollisionObjectWrapper*, int, int) override {
    found =
        found || point.getDistance() < -0.5f; // neighbours that only touch are at 0, those in one cell at -1
    return 0;
  }
};

class Voxels : public BulletVoxels {
public:
  Voxels(const std::vector<Vec3>& still, const std::vector<Vec3>& tool) : still_(still), tool_(tool) {
    configuration_.setConvexConvexMultipointIterations(0, 0);
    world_.addCollisionObject(&still_.object());
  }
  ~Voxels() override { world_.removeCollisionObject(&still_.object()); }

  bool touches(double x, double y, double z) override {
    tool_.object().getWorldTransform().setOrigin(
        {static_cast<btScalar>(x), static_cast<btScalar>(y), static_cast<btScalar>(z)});
    AnyContact any;
    world_.contactPairTest(&still_.object(), &tool_.object(), any);
    return any.found;
  }

private:
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_{&dispatcher_, &broadphase_, &configuration_};
  Compound still_, tool_;
};

} // namespace

std::unique_ptr<BulletVoxels> bullet_voxels(const std::vector<Vec3>& still, const std::vector<Vec3>& tool) {
  return std::make_unique<Voxels>(still, tool);
}

} // namespace maille::lab
