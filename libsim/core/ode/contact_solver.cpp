// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/ode/contact_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <vector>

#include "libsim/core/ode/geometry.hpp"
#include "libsim/core/ode/static_bounds.hpp"

namespace cas::sim {

static_assert(sizeof(dReal) == sizeof(double), "CAS needs ODE in double precision");

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMaxContactsPerPair = 8;

// A contact as a mass on a spring: stiff enough to sink by about a millimetre, damped so that it
// does not bounce. Scaled by the body's mass, so that small and large vehicles land alike.
constexpr double kContactFrequency = 94.0;  // rad/s, one contact carrying the whole body
constexpr double kContactDampingRatio = 1.0;
constexpr double kSlipSpeed = 1e-3;   // m/s: above, friction points against the slip
constexpr double kDeepestPush = 5.0;  // m/s: speed at which overlapping bodies are parted
constexpr unsigned long kOdeSeed = 1;

dMass ode_mass(const MassProperties& mass) {
  const Eigen::Matrix3d& i = mass.inertia_B();
  dMass out;
  dMassSetParameters(&out, mass.mass_kg(), 0, 0, 0, i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2),
                     i(1, 2));
  return out;
}

/// ODE's library state lives as long as any solver.
class OdeLibrary {
 public:
  OdeLibrary() {
    if (users_++ == 0) dInitODE2(0);
  }
  ~OdeLibrary() {
    if (--users_ == 0) dCloseODE();
  }
  OdeLibrary(const OdeLibrary&) = delete;
  OdeLibrary& operator=(const OdeLibrary&) = delete;

 private:
  static inline int users_ = 0;
};

struct Body {
  dBodyID id = nullptr;
  dSpaceID space = nullptr;
  double radius = 0;
  double mass_kg = 0;
  bool driven = false;  // an obstacle on its way: nothing that touches it moves it
  bool touching = false;
};

/// What a geom belongs to; pointed to by the geom.
struct Owner {
  Surface surface;
  std::ptrdiff_t body = -1;  // -1: the world
};

}  // namespace

struct ContactSolver::Impl {
  OdeLibrary library;
  dWorldID world = dWorldCreate();
  dSpaceID statics = dHashSpaceCreate(nullptr);
  dJointGroupID contacts = dJointGroupCreate(0);
  dGeomID ray = dCreateRay(nullptr, 1.0);
  MeshStore meshes;
  std::deque<Owner> owners;
  std::vector<Body> bodies;
  StaticBounds bounds;
  std::size_t contact_count = 0;
  double h = 1e-3;  // s, step that the springs are discretised for

  ~Impl() {
    dGeomDestroy(ray);
    dJointGroupDestroy(contacts);
    for (const Body& body : bodies) dSpaceDestroy(body.space);
    dSpaceDestroy(statics);
    dWorldDestroy(world);
  }

  void collide(dGeomID a, dGeomID b) {
    std::array<dContact, kMaxContactsPerPair> found;
    const int n = dCollide(a, b, static_cast<int>(kMaxContactsPerPair), &found[0].geom,
                           static_cast<int>(sizeof(dContact)));
    for (int i = 0; i < n; ++i) add_contact(found[static_cast<std::size_t>(i)]);
  }

  void add_contact(dContact& contact) {
    const auto& a = *static_cast<const Owner*>(dGeomGetData(contact.geom.g1));
    const auto& b = *static_cast<const Owner*>(dGeomGetData(contact.geom.g2));
    ++contact_count;
    fill_surface(contact, a, b);
    const dBodyID body_a = dGeomGetBody(contact.geom.g1);
    const dBodyID body_b = dGeomGetBody(contact.geom.g2);
    dJointAttach(dJointCreateContact(world, contacts, &contact), body_a, body_b);
    if (a.body >= 0) bodies[static_cast<std::size_t>(a.body)].touching = true;
    if (b.body >= 0) bodies[static_cast<std::size_t>(b.body)].touching = true;
  }

  void fill_surface(dContact& contact, const Owner& a, const Owner& b) const {
    dSurfaceParameters& surface = contact.surface;
    surface = {};
    surface.mode = dContactApprox1 | dContactSoftERP | dContactSoftCFM;
    surface.mu = std::min(a.surface.friction, b.surface.friction);
    const double mass = std::max(mass_of(a), mass_of(b));
    const double stiffness = mass * kContactFrequency * kContactFrequency;
    const double damping = 2.0 * kContactDampingRatio * mass * kContactFrequency;
    surface.soft_erp = h * stiffness / (h * stiffness + damping);
    surface.soft_cfm = 1.0 / (h * stiffness + damping);
    align_friction(contact);
  }

  /// What gives way at a contact, kg; 0 for the world and for obstacles.
  double mass_of(const Owner& owner) const {
    if (owner.body < 0) return 0.0;
    const Body& body = bodies[static_cast<std::size_t>(owner.body)];
    return body.driven ? 0.0 : body.mass_kg;
  }

  /// ODE's friction pyramid is exact along its axes: turn one against the slip.
  static void align_friction(dContact& contact) {
    const Eigen::Vector3d n = from_ode(contact.geom.normal);
    Eigen::Vector3d slip = velocity_at(contact.geom.g1, contact.geom.pos) -
                           velocity_at(contact.geom.g2, contact.geom.pos);
    slip -= n.dot(slip) * n;
    const double speed = slip.norm();
    if (speed < kSlipSpeed) return;
    slip /= speed;
    contact.surface.mode |= dContactFDir1;
    std::copy_n(slip.data(), 3, contact.fdir1);
  }

  static Eigen::Vector3d velocity_at(dGeomID geom, const dReal* p) {
    const dBodyID body = dGeomGetBody(geom);
    if (body == nullptr) return Eigen::Vector3d::Zero();
    dVector3 v;
    dBodyGetPointVel(body, p[0], p[1], p[2], v);
    return from_ode(v);
  }

  std::optional<double> cast(dSpaceID space, const Eigen::Vector3d& origin,
                             const Eigen::Vector3d& direction, double range) const {
    dGeomRaySet(ray, origin.x(), origin.y(), origin.z(), direction.x(), direction.y(),
                direction.z());
    dGeomRaySetLength(ray, range);
    double nearest = kInfinity;
    dSpaceCollide2(ray, reinterpret_cast<dGeomID>(space), &nearest, &on_ray);
    if (nearest > range) return std::nullopt;
    return nearest;
  }

  static void on_ray(void* nearest, dGeomID a, dGeomID b) {
    dContactGeom hit;
    if (dCollide(a, b, 1, &hit, sizeof(hit)) == 0) return;
    auto& best = *static_cast<double*>(nearest);
    best = std::min(best, hit.depth);  // of a ray: the distance
  }

  static void on_pair(void* self, dGeomID a, dGeomID b) { static_cast<Impl*>(self)->collide(a, b); }
};

ContactSolver::ContactSolver(const Eigen::Vector3d& gravity_W) : impl_(std::make_unique<Impl>()) {
  dWorldSetGravity(impl_->world, gravity_W.x(), gravity_W.y(), gravity_W.z());
  dWorldSetContactMaxCorrectingVel(impl_->world, kDeepestPush);
  dWorldSetAutoDisableFlag(impl_->world, 0);
  reset();
}

ContactSolver::~ContactSolver() = default;

void ContactSolver::add_static(const Shape& shape) {
  const dGeomID geom = make_geom(impl_->statics, shape, impl_->meshes);
  impl_->owners.push_back({shape.surface, -1});
  dGeomSetData(geom, &impl_->owners.back());
  impl_->bounds.add(shape, geom);
}

void ContactSolver::add_body(std::span<const Shape> shapes, const MassProperties& mass) {
  Body body;
  body.id = dBodyCreate(impl_->world);
  body.space = dSimpleSpaceCreate(nullptr);
  const auto index = static_cast<std::ptrdiff_t>(impl_->bodies.size());
  for (const Shape& shape : shapes) {
    const dGeomID geom = make_geom(body.space, shape, impl_->meshes);
    impl_->owners.push_back({shape.surface, index});
    dGeomSetData(geom, &impl_->owners.back());
    dGeomSetBody(geom, body.id);
    const Eigen::Vector3d p = shape.pose.translation();
    dReal q[4];
    to_ode(Eigen::Quaterniond(shape.pose.linear()), q);
    dGeomSetOffsetPosition(geom, p.x(), p.y(), p.z());
    dGeomSetOffsetQuaternion(geom, q);
    body.radius = std::max(body.radius, bounding_radius(shape));
  }
  dBodyDisable(body.id);
  impl_->bodies.push_back(body);
  set_mass(impl_->bodies.size() - 1, mass);
}

std::size_t ContactSolver::add_obstacle(std::span<const Shape> shapes) {
  add_body(shapes, MassProperties(1.0, Eigen::Matrix3d::Identity()));  // which nothing asks for
  Body& obstacle = impl_->bodies.back();
  obstacle.driven = true;
  dBodySetKinematic(obstacle.id);
  return impl_->bodies.size() - 1;
}

void ContactSolver::set_mass(std::size_t body, const MassProperties& mass) {
  const dMass m = ode_mass(mass);
  dBodySetMass(impl_->bodies[body].id, &m);
  impl_->bodies[body].mass_kg = mass.mass_kg();
}

bool ContactSolver::near_world(std::size_t body, const Eigen::Vector3d& p_W) const {
  return impl_->bounds.within(p_W, impl_->bodies[body].radius);
}

bool ContactSolver::near_each_other(std::size_t a, const Eigen::Vector3d& p_a_W, std::size_t b,
                                    const Eigen::Vector3d& p_b_W) const {
  const double reach = impl_->bodies[a].radius + impl_->bodies[b].radius;
  return (p_a_W - p_b_W).squaredNorm() <= reach * reach;
}

void ContactSolver::begin(double dt) {
  impl_->h = dt;
  dJointGroupEmpty(impl_->contacts);
  for (Body& body : impl_->bodies) {
    body.touching = false;
    dBodyDisable(body.id);
  }
}

void ContactSolver::place(std::size_t body, const BodyState& state) {
  const dBodyID id = impl_->bodies[body].id;
  dReal q[4];
  to_ode(state.q_WB, q);
  const Eigen::Vector3d w_W = state.q_WB * state.w_WB_B;
  dBodySetPosition(id, state.p_WB.x(), state.p_WB.y(), state.p_WB.z());
  dBodySetQuaternion(id, q);
  dBodySetLinearVel(id, state.v_WB.x(), state.v_WB.y(), state.v_WB.z());
  dBodySetAngularVel(id, w_W.x(), w_W.y(), w_W.z());
}

void ContactSolver::collide_world(std::size_t body) {
  dSpaceCollide2(reinterpret_cast<dGeomID>(impl_->bodies[body].space),
                 reinterpret_cast<dGeomID>(impl_->statics), impl_.get(), &Impl::on_pair);
}

bool ContactSolver::collide_bodies(std::size_t a, std::size_t b) {
  const std::size_t before = impl_->contact_count;
  dSpaceCollide2(reinterpret_cast<dGeomID>(impl_->bodies[a].space),
                 reinterpret_cast<dGeomID>(impl_->bodies[b].space), impl_.get(), &Impl::on_pair);
  return impl_->contact_count != before;
}

bool ContactSolver::touching(std::size_t body) const { return impl_->bodies[body].touching; }

void ContactSolver::apply(std::size_t body, const Wrench& wrench) {
  const dBodyID id = impl_->bodies[body].id;
  const Eigen::Vector3d& f = wrench.force_B;
  const Eigen::Vector3d& t = wrench.torque_B;
  dBodyEnable(id);
  dBodyAddRelForce(id, f.x(), f.y(), f.z());
  dBodyAddRelTorque(id, t.x(), t.y(), t.z());
}

void ContactSolver::step() { dWorldStep(impl_->world, impl_->h); }

void ContactSolver::read(std::size_t body, BodyState& state) const {
  const dBodyID id = impl_->bodies[body].id;
  const dReal* q = dBodyGetQuaternion(id);
  state.p_WB = from_ode(dBodyGetPosition(id));
  state.v_WB = from_ode(dBodyGetLinearVel(id));
  state.q_WB = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  state.w_WB_B = state.q_WB.conjugate() * from_ode(dBodyGetAngularVel(id));
}

std::optional<double> ContactSolver::ray_to_world(const Eigen::Vector3d& origin_W,
                                                  const Eigen::Vector3d& direction_W,
                                                  double range_m) const {
  return impl_->cast(impl_->statics, origin_W, direction_W, range_m);
}

std::optional<double> ContactSolver::ray_to_body(std::size_t body, const Eigen::Vector3d& origin_W,
                                                 const Eigen::Vector3d& direction_W,
                                                 double range_m) const {
  return impl_->cast(impl_->bodies[body].space, origin_W, direction_W, range_m);
}

double ContactSolver::height_above_ground(const Eigen::Vector3d& p_W) const {
  const double height = impl_->bounds.height_above_planes(p_W);
  if (!impl_->bounds.box_below(p_W)) return height;
  const double range = p_W.z() - impl_->bounds.lowest_of_boxes() + 1.0;
  const auto hit = ray_to_world(p_W, -Eigen::Vector3d::UnitZ(), range);
  return hit ? std::min(height, *hit) : height;
}

double ContactSolver::radius(std::size_t body) const { return impl_->bodies[body].radius; }

void ContactSolver::reset() { dRandSetSeed(kOdeSeed); }

}  // namespace cas::sim
