// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/ode/contact_solver.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "base/os/log.hpp"
#include "libsim/core/ode/ball_on_mesh.hpp"
#include "libsim/core/ode/box_faces.hpp"
#include "libsim/core/ode/contact_law.hpp"
#include "libsim/core/ode/contact_patch.hpp"
#include "libsim/core/ode/cylinder_base.hpp"
#include "libsim/core/ode/flat_ground.hpp"
#include "libsim/core/ode/geometry.hpp"
#include "libsim/core/ode/remembered_points.hpp"
#include "libsim/core/ode/static_bounds.hpp"
#include "libsim/core/ode/terrain_patches.hpp"

namespace cas::sim {

static_assert(sizeof(dReal) == sizeof(double), "CAS needs ODE in double precision");

namespace {

constexpr std::size_t kMostFound = 512;  // contacts of one pair of shapes that are looked at
constexpr double kDeepestPush = 5.0;     // m/s: speed at which overlapping bodies are parted
constexpr double kNoSlip = 1e-9;         // m/s: below, slip has no direction
constexpr double kStill = 2e-5;          // m: below, a body keeps its contacts
constexpr double kSlide = 0.1;           // m: way between two searches for flat ground
constexpr double kSlow_m_s = 0.1;        // a body below this settles on triangles
constexpr unsigned long kOdeSeed = 1;

dMass ode_mass(const MassProperties& mass) {
  const Eigen::Matrix3d& i = mass.inertia_B();
  dMass out;
  dMassSetParameters(&out, mass.mass_kg(), 0, 0, 0, i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2),
                     i(1, 2));
  return out;
}

/// Where ODE's messages go; it would write them to standard error.
///
/// ODE's solver complains of contacts that contradict each other, step by step and in its own
/// words: one warning says so, the rest is counted. After an error ODE ends the program, and its
/// destructors do not bear an exception: step() leaves it by a jump.
class OdeMessages {
 public:
  static void install() {
    dSetMessageHandler(&OdeMessages::on_message);
    dSetErrorHandler(&OdeMessages::on_error);
    dSetDebugHandler(&OdeMessages::on_error);
  }
  static std::uint64_t count() { return count_.load(std::memory_order_relaxed); }

  /// dWorldStep(). @return false after an error(): the world is of no further use, nor to destroy
  static bool step(dWorldID world, double dt) {
    std::jmp_buf way_out;
    way_out_ = &way_out;
    if (setjmp(way_out) != 0) return false;
    dWorldStep(world, dt);
    way_out_ = nullptr;
    return true;
  }
  /// ODE's words.
  static std::string error() { return error_.data(); }

 private:
  using Buffer = std::array<char, 256>;

  static void on_message(int, const char* format, va_list arguments) {
    if (count_.fetch_add(1, std::memory_order_relaxed) > 0) return;
    Buffer buffer{};
    std::vsnprintf(buffer.data(), buffer.size(), format, arguments);
    base::log::warn("contact solver: " + std::string(buffer.data()) + "; further ones are counted");
  }
  [[noreturn]] static void on_error(int, const char* format, va_list arguments) {
    std::vsnprintf(error_.data(), error_.size(), format, arguments);
    if (std::jmp_buf* const way_out = std::exchange(way_out_, nullptr)) std::longjmp(*way_out, 1);
    base::log::error("contact solver: " + error());
    std::abort();
  }

  static inline std::atomic<std::uint64_t> count_{0};
  static inline thread_local std::jmp_buf* way_out_ = nullptr;
  static inline thread_local Buffer error_{};
};

/// ODE's library state lives as long as any solver.
class OdeLibrary {
 public:
  OdeLibrary() {
    if (users_++ > 0) return;
    OdeMessages::install();
    dInitODE2(0);
  }
  ~OdeLibrary() {
    if (--users_ == 0) dCloseODE();
  }
  OdeLibrary(const OdeLibrary&) = delete;
  OdeLibrary& operator=(const OdeLibrary&) = delete;

 private:
  static inline int users_ = 0;
};

/// Body and surface that own a geom; the geom points to it.
struct Owner {
  std::ptrdiff_t body = -1;  // -1: the world
  std::size_t surface = 0;   // its number
};

/// Whose surfaces touch: bodies, -1 for the world, and numbers of surfaces.
struct Pair {
  std::ptrdiff_t body = -1;
  std::ptrdiff_t other = -1;
  std::size_t on_body = 0;
  std::size_t on_other = 0;

  bool operator==(const Pair&) const = default;
};

/// A contact that takes part in the step.
struct Contact {
  ContactPoint point;
  std::size_t patch = 0;
  std::ptrdiff_t body = -1;   // n_W points into it
  std::ptrdiff_t other = -1;  // -1: the world
  Surface on_body;
  Surface on_other;
};

struct Body {
  dBodyID id = nullptr;
  dSpaceID space = nullptr;
  double radius = 0;
  MassProperties mass;
  bool driven = false;  // an obstacle on its way: nothing that touches it moves it
  bool touching = false;

  // Contacts with the static world, and where the body was when they were looked for.
  std::vector<Contact> world_contacts;
  RememberedPoints remembered;
  bool looked = false;
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();

  // The flat surface around the body, if there is one, and where it was searched for.
  std::optional<FlatSurface> flat;
  bool asked = false;
  Eigen::Vector3d asked_at_W = Eigen::Vector3d::Zero();

  // Velocities that the body would have after the step if nothing touched it.
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d w_W = Eigen::Vector3d::Zero();
};

Eigen::Quaterniond attitude(dBodyID id) {
  const dReal* q = dBodyGetQuaternion(id);
  return {q[0], q[1], q[2], q[3]};
}

}  // namespace

struct ContactSolver::Impl {
  OdeLibrary library;
  dWorldID world = dWorldCreate();
  dSpaceID statics = dHashSpaceCreate(nullptr);
  dJointGroupID joints = dJointGroupCreate(0);
  dGeomID ray = dCreateRay(nullptr, 1.0);
  dGeomID plane = dCreatePlane(nullptr, 0, 0, 1, 0);  // stands for a flat surface of triangles
  FlatGround flat_ground;
  BallOnMesh ball_on_mesh;
  MeshStore meshes;
  std::deque<Owner> owners;
  std::vector<Surface> surfaces;
  std::vector<Body> bodies;
  StaticBounds bounds;
  std::optional<TerrainPatches> terrain;
  Eigen::Vector3d gravity_W = Eigen::Vector3d::Zero();
  bool has_given_up = false;
  double h = 1e-3;  // s, step that the springs are discretised for

  std::vector<std::pair<double, dGeomID>> discs;  // by radius
  std::vector<Contact> contacts;                  // of the step
  std::vector<dContactGeom> geoms;                // of one pair of shapes
  std::vector<ContactPoint> points;               // of one body with the world, or with another
  std::vector<Pair> pairs;                        // all that have touched, by their `kind`
  std::vector<ContactPoint> spread;               // room for spread_curved_patches()
  std::vector<KeptContact> kept;

  Impl() : geoms(kMostFound) {
    dGeomRaySetClosestHit(ray, 1);  // of a mesh's triangles; else any that it meets
    contacts.reserve(kMostFound);
    pairs.reserve(kMostFound);
    points.reserve(kMostFound + RememberedPoints::kMost);
    spread.reserve(kMostFound + RememberedPoints::kMost);
    kept.reserve(kMostContacts);
  }

  ~Impl() {
    dGeomDestroy(ray);
    dGeomDestroy(plane);
    for (const auto& [radius, geom] : discs) dGeomDestroy(geom);
    dJointGroupDestroy(joints);
    for (const Body& body : bodies) dSpaceDestroy(body.space);
    dSpaceDestroy(statics);
    dWorldDestroy(world);
  }

  Body& at(std::ptrdiff_t body) { return bodies[static_cast<std::size_t>(body)]; }

  Owner* own(const Surface& surface, std::ptrdiff_t body) {
    const auto same = std::find(surfaces.begin(), surfaces.end(), surface);
    const auto number = static_cast<std::size_t>(same - surfaces.begin());
    if (same == surfaces.end()) surfaces.push_back(surface);
    owners.push_back({body, number});
    return &owners.back();
  }

  // --- finding contacts

  static void on_pair(void* self, dGeomID a, dGeomID b) { static_cast<Impl*>(self)->collide(a, b); }

  void collide(dGeomID a, dGeomID b) {
    const std::size_t n = find_contacts(a, b);
    for (std::size_t i = 0; i < n; ++i) add_point(geoms[i]);
  }

  /// Writes the contacts of two shapes to `geoms`. @return their number
  std::size_t find_contacts(dGeomID a, dGeomID b) {
    if (const auto count = collide_base(a, b, geoms)) return *count;
    if (const auto count = ball_on_mesh.collide(a, b, geoms)) return *count;
    const auto count = static_cast<std::size_t>(dCollide(
        a, b, static_cast<int>(kMostFound), geoms.data(), static_cast<int>(sizeof(dContactGeom))));
    return collide_faces(std::span(geoms).first(count), geoms).value_or(count);
  }

  /// Books a contact from the side of a body; of two bodies, of the one that ODE names first.
  void add_point(const dContactGeom& geom) {
    const auto* a = static_cast<const Owner*>(dGeomGetData(geom.g1));
    const auto* b = static_cast<const Owner*>(dGeomGetData(geom.g2));
    Eigen::Vector3d n_W = from_ode(geom.normal);
    if (a->body < 0) {
      std::swap(a, b);
      n_W = -n_W;
    }
    points.push_back({.p_W = from_ode(geom.pos),
                      .n_W = n_W,
                      .depth_m = geom.depth,
                      .kind = kind_of({a->body, b->body, a->surface, b->surface}),
                      .face_W = face_of(geom)});
  }

  /// Number of the pair among all that have touched.
  std::size_t kind_of(const Pair& pair) {
    const auto same = std::find(pairs.begin(), pairs.end(), pair);
    if (same == pairs.end()) {
      pairs.push_back(pair);
      return pairs.size() - 1;
    }
    return static_cast<std::size_t>(same - pairs.begin());
  }

  /// Unit normal of the triangle that the contact is with; zero where there is none.
  static Eigen::Vector3d face_of(const dContactGeom& geom) {
    const bool first = dGeomGetClass(geom.g1) == dTriMeshClass;
    const dGeomID mesh = first ? geom.g1 : geom.g2;
    const int triangle = first ? geom.side1 : geom.side2;
    if (dGeomGetClass(mesh) != dTriMeshClass || triangle < 0) return Eigen::Vector3d::Zero();
    return normal_of(triangle_of(mesh, triangle));
  }

  /// Appends to `out` the contacts of `points` that carry the body.
  void keep_points(std::vector<Contact>& out) {
    drop_inner_edges(points);
    spread_curved_patches(points, spread);
    keep_outermost(points, kept);
    for (const KeptContact& k : kept) {
      const ContactPoint& point = points[k.index];
      const Pair& pair = pairs[point.kind];
      out.push_back({.point = point,
                     .patch = k.patch,
                     .body = pair.body,
                     .other = pair.other,
                     .on_body = surfaces[pair.on_body],
                     .on_other = surfaces[pair.on_other]});
    }
  }

  /// Whether the body's last contacts still hold: it has not moved since.
  static bool touches_the_same(const Body& body) {
    const Eigen::Vector3d moved = from_ode(dBodyGetPosition(body.id)) - body.p_WB;
    const Eigen::Vector3d turned = 2.0 * (attitude(body.id) * body.q_WB.conjugate()).vec();
    return moved.norm() + turned.norm() * body.radius <= kStill;
  }

  /// The body's motion since its last search for contacts.
  static BodyMove move_of(const Body& body) {
    return {.from_W = body.p_WB,
            .to_W = from_ode(dBodyGetPosition(body.id)),
            .turn = attitude(body.id) * body.q_WB.conjugate()};
  }

  static bool is_slow(const Body& body) {
    const double turning_m_s = from_ode(dBodyGetAngularVel(body.id)).norm() * body.radius;
    return from_ode(dBodyGetLinearVel(body.id)).norm() + turning_m_s < kSlow_m_s;
  }

  void look_for_world_contacts(Body& body) {
    points.clear();
    find_world_points(body);
    if (terrain) find_terrain_points(body);
    if (is_slow(body) && face_more_than_one_way(points)) {
      body.remembered.add_to(points, move_of(body));
    } else {
      body.remembered.forget();
    }
    body.world_contacts.clear();
    keep_points(body.world_contacts);
    body.p_WB = from_ode(dBodyGetPosition(body.id));
    body.q_WB = attitude(body.id);
    body.looked = true;
  }

  /// Finds the body's points on the world. A plane replaces the triangles of a mesh that is flat
  /// all around the body: it has the same contacts, and thousands of small triangles would take
  /// milliseconds. A body in contact searches for flat ground again after each 10 cm.
  void find_world_points(Body& body) {
    const Eigen::Vector3d p_W = from_ode(dBodyGetPosition(body.id));
    const bool is_asked = body.asked && (p_W - body.asked_at_W).norm() <= kSlide;
    if (is_asked && body.flat) return find_points_on(*body.flat, body);
    if (is_asked) return find_points_on_shapes(body);
    const bool touched = !body.world_contacts.empty();
    if (!touched) find_points_on_shapes(body);
    if (!touched && points.empty()) return;
    body.flat = flat_ground.around(statics, p_W, body.radius + kSlide);
    body.asked = true;
    body.asked_at_W = p_W;
    if (body.flat) {
      points.clear();
      find_points_on(*body.flat, body);
    } else if (touched) {
      find_points_on_shapes(body);
    }
  }

  /// Adds the body's points on the terrain, on a plane where that is flat all around the body.
  void find_terrain_points(Body& body) {
    const Eigen::Vector3d p_W = from_ode(dBodyGetPosition(body.id));
    if (!terrain->within(p_W, body.radius)) return;
    const Eigen::Vector3d anchor_W = terrain->bring(p_W, body.radius);
    const Eigen::Vector3d p = p_W - anchor_W;
    const Terrain& ground = terrain->terrain();
    const Eigen::Vector3d below_W(p_W.x(), p_W.y(), ground.height_m(p_W.x(), p_W.y()));
    if (p_W.z() < below_W.z()) {  // fast: it would pass through triangles, and a plane is solid
      const Eigen::Vector3d n_W = ground.normal_W(p_W.x(), p_W.y());
      return find_points_on({.ground = {.n_W = n_W, .height_m = n_W.dot(below_W)},
                             .mesh = dSpaceGetGeom(terrain->space(), 0)},
                            body);
    }
    if (auto flat = flat_ground.around(terrain->space(), p, body.radius)) {
      flat->ground.height_m += flat->ground.n_W.dot(anchor_W);
      return find_points_on(*flat, body);
    }
    const std::size_t others = points.size();
    dBodySetPosition(body.id, p.x(), p.y(), p.z());
    dSpaceCollide2(reinterpret_cast<dGeomID>(body.space),
                   reinterpret_cast<dGeomID>(terrain->space()), this, &on_pair);
    dBodySetPosition(body.id, p_W.x(), p_W.y(), p_W.z());
    for (std::size_t i = others; i < points.size(); ++i) points[i].p_W += anchor_W;
  }

  void find_points_on_shapes(Body& body) {
    dSpaceCollide2(reinterpret_cast<dGeomID>(body.space), reinterpret_cast<dGeomID>(statics), this,
                   &on_pair);
  }

  void find_points_on(const FlatSurface& surface, Body& body) {
    const HalfSpace& ground = surface.ground;
    dGeomPlaneSetParams(plane, ground.n_W.x(), ground.n_W.y(), ground.n_W.z(), ground.height_m);
    dGeomSetData(plane, dGeomGetData(surface.mesh));
    dSpaceCollide2(reinterpret_cast<dGeomID>(body.space), plane, this, &on_pair);
  }

  /// Adds the body's contacts with the world, each as deep as it is by now.
  void add_world_contacts(Body& body) {
    const BodyMove move = move_of(body);
    for (Contact contact : body.world_contacts) {
      move.carry(contact.point);
      if (contact.point.depth_m < 0) continue;
      contacts.push_back(contact);
      body.touching = true;
    }
  }

  // --- joints

  /// Makes a joint of each contact; the bodies' velocities without contact decide on friction.
  void make_joints() {
    for (Body& body : bodies) predict(body);
    for (std::size_t first = 0; first < contacts.size();) {
      std::size_t last = first + 1;
      while (last < contacts.size() && same_patch(contacts[first], contacts[last])) ++last;
      make_joints_of_patch(std::span(contacts).subspan(first, last - first));
      first = last;
    }
  }

  static bool same_patch(const Contact& a, const Contact& b) {
    return a.body == b.body && a.other == b.other && a.patch == b.patch;
  }

  void predict(Body& body) const {
    body.v_W = from_ode(dBodyGetLinearVel(body.id));
    body.w_W = from_ode(dBodyGetAngularVel(body.id));
    if (body.driven || dBodyIsEnabled(body.id) == 0) return;
    const Eigen::Matrix3d R_WB = attitude(body.id).toRotationMatrix();
    const Eigen::Vector3d w_B = R_WB.transpose() * body.w_W;
    const Eigen::Vector3d t_B = R_WB.transpose() * from_ode(dBodyGetTorque(body.id));
    const Eigen::Vector3d alpha_B =
        body.mass.inertia_inverse_B() * (t_B - w_B.cross(body.mass.inertia_B() * w_B));
    body.v_W += h * (gravity_W + from_ode(dBodyGetForce(body.id)) / body.mass.mass_kg());
    body.w_W += h * (R_WB * alpha_B);
  }

  void make_joints_of_patch(std::span<const Contact> patch) {
    const Contact& any = patch.front();
    const double mass = std::max(mass_of(any.body), mass_of(any.other));
    const bool own = has_own_spring(any.on_body, any.on_other);
    double depth_sum = 0;
    Eigen::Vector3d moment_W = Eigen::Vector3d::Zero();  // of the depths
    for (const Contact& contact : patch) {
      depth_sum += contact.point.depth_m;
      moment_W += contact.point.depth_m * contact.point.p_W;
    }
    const Eigen::Vector3d middle_W = depth_sum > 0 ? moment_W / depth_sum : any.point.p_W;
    const double felt = std::max(felt_mass_of(any.body, middle_W, any.point.n_W),
                                 felt_mass_of(any.other, middle_W, any.point.n_W));
    const auto spring_of = [&](const Contact& contact) {
      return own ? own_spring(contact.on_body, contact.on_other)
                 : default_spring(felt, contact.point.depth_m, depth_sum, patch.size());
    };
    double load = 0;  // N, about
    for (const Contact& contact : patch) {
      const double approach = -contact.point.n_W.dot(slip_at(contact));
      load += spring_of(contact).force(contact.point.depth_m, approach);
    }
    const double friction = std::min(any.on_body.friction, any.on_other.friction);
    const double stop = friction * load / mass * h;
    for (const Contact& contact : patch) {
      make_joint(contact, spring_of(contact), friction, stop);
    }
  }

  /// @param stop  m/s: speed that friction can remove in this step
  void make_joint(const Contact& contact, const ContactSpring& spring, double friction,
                  double stop) {
    const ContactPoint& point = contact.point;
    dContact joint{};
    std::copy_n(point.p_W.data(), 3, joint.geom.pos);
    std::copy_n(point.n_W.data(), 3, joint.geom.normal);
    joint.geom.depth = point.depth_m;
    dSurfaceParameters& surface = joint.surface;
    surface.mode = dContactApprox1 | dContactSoftERP | dContactSoftCFM;
    const double implicit = h * spring.stiffness + spring.damping;
    surface.soft_erp = h * spring.stiffness / implicit;
    surface.soft_cfm = 1.0 / implicit;
    surface.mu = friction;
    Eigen::Vector3d slip = slip_at(contact);
    slip -= point.n_W.dot(slip) * point.n_W;
    const double speed = slip.norm();
    if (speed > kNoSlip) {
      slip /= speed;
      surface.mode |= dContactFDir1 | dContactMu2;
      surface.mu2 = friction * hold_across(speed, stop);
      std::copy_n(slip.data(), 3, joint.fdir1);
    }
    const dBodyID other = contact.other < 0 ? nullptr : at(contact.other).id;
    dJointAttach(dJointCreateContact(world, joints, &joint), at(contact.body).id, other);
  }

  /// Mass that moves at a contact, kg; 0 for the world and for obstacles.
  double mass_of(std::ptrdiff_t body) {
    return body < 0 || at(body).driven ? 0.0 : at(body).mass.mass_kg();
  }

  /// The mass that a push along n_W at a point has to move: 1 / (1/m + (r x n) I^-1 (r x n)), all
  /// of it only where the push goes through the centre of gravity ([Mirtich-Canny]).
  double felt_mass_of(std::ptrdiff_t body, const Eigen::Vector3d& p_W, const Eigen::Vector3d& n_W) {
    const double mass = mass_of(body);
    if (mass == 0) return 0;
    const Body& own = at(body);
    const Eigen::Vector3d arm_W = (p_W - from_ode(dBodyGetPosition(own.id))).cross(n_W);
    const Eigen::Vector3d arm_B = attitude(own.id).conjugate() * arm_W;
    return mass / (1 + mass * arm_B.dot(own.mass.inertia_inverse_B() * arm_B));
  }

  /// Velocity of the body at the contact against the other side, after the step without contact.
  Eigen::Vector3d slip_at(const Contact& contact) {
    const Eigen::Vector3d v_W = velocity_at(contact.body, contact.point.p_W);
    return contact.other < 0 ? v_W : v_W - velocity_at(contact.other, contact.point.p_W);
  }
  Eigen::Vector3d velocity_at(std::ptrdiff_t index, const Eigen::Vector3d& p_W) {
    const Body& body = at(index);
    return body.v_W + body.w_W.cross(p_W - from_ode(dBodyGetPosition(body.id)));
  }

  // --- discs

  /// Whether the disc meets anything in the space.
  bool meets(const Disc& disc, dSpaceID space) {
    const dGeomID geom = disc_of(disc.radius_m);
    dReal q[4];
    to_ode(disc.q_WD, q);
    dGeomSetPosition(geom, disc.centre_W.x(), disc.centre_W.y(), disc.centre_W.z());
    dGeomSetQuaternion(geom, q);
    bool met = false;
    dSpaceCollide2(geom, reinterpret_cast<dGeomID>(space), &met, &on_disc);
    return met;
  }

  bool meets_terrain(Disc disc) {
    if (!terrain || !terrain->within(disc.centre_W, disc.radius_m)) return false;
    disc.centre_W -= terrain->bring(disc.centre_W, disc.radius_m);
    return meets(disc, terrain->space());
  }

  static void on_disc(void* met, dGeomID a, dGeomID b) {
    dContactGeom hit;
    auto& any = *static_cast<bool*>(met);
    any = any || dCollide(a, b, 1, &hit, sizeof(hit)) > 0;
  }

  /// The disc of that radius, made at first use. Of triangles: ODE has no contacts between
  /// cylinders.
  dGeomID disc_of(double radius) {
    for (const auto& [made, geom] : discs) {
      if (made == radius) return geom;
    }
    constexpr std::uint32_t kCorners = 24;
    TriangleMesh mesh;
    mesh.vertices.push_back(Eigen::Vector3d::Zero());
    for (std::uint32_t i = 0; i < kCorners; ++i) {
      const double angle = 2 * M_PI * i / kCorners;
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
      mesh.triangles.push_back({0, i + 1, (i + 1) % kCorners + 1});
    }
    const dGeomID geom = dCreateTriMesh(
        nullptr, meshes.add(std::make_shared<const TriangleMesh>(mesh)), nullptr, nullptr, nullptr);
    discs.emplace_back(radius, geom);
    return geom;
  }

  // --- rays

  std::optional<RayHit> cast(dSpaceID space, const Eigen::Vector3d& origin,
                             const Eigen::Vector3d& direction, double range) const {
    dGeomRaySet(ray, origin.x(), origin.y(), origin.z(), direction.x(), direction.y(),
                direction.z());
    dGeomRaySetLength(ray, range);
    RayHit nearest;
    dSpaceCollide2(ray, reinterpret_cast<dGeomID>(space), &nearest, &on_ray);
    if (nearest.distance_m > range) return std::nullopt;
    if (nearest.normal.dot(direction) > 0) nearest.normal = -nearest.normal;
    return nearest;
  }

  static void on_ray(void* nearest, dGeomID a, dGeomID b) {
    dContactGeom hit;
    if (dCollide(a, b, 1, &hit, sizeof(hit)) == 0) return;
    auto& best = *static_cast<RayHit*>(nearest);
    if (hit.depth < best.distance_m) best = {hit.depth, from_ode(hit.normal)};  // depth: distance
  }
};

ContactSolver::ContactSolver(const Eigen::Vector3d& gravity_W) : impl_(std::make_unique<Impl>()) {
  impl_->gravity_W = gravity_W;
  dWorldSetGravity(impl_->world, gravity_W.x(), gravity_W.y(), gravity_W.z());
  dWorldSetContactMaxCorrectingVel(impl_->world, kDeepestPush);
  dWorldSetAutoDisableFlag(impl_->world, 0);
  reset();
}

ContactSolver::~ContactSolver() {
  // ODE could not destroy it: it stays, and is known to leak checkers.
  static auto& abandoned = *new std::vector<std::unique_ptr<Impl>>;
  if (impl_->has_given_up) abandoned.push_back(std::move(impl_));
}

void ContactSolver::add_static(const Shape& shape) {
  const dGeomID geom = make_geom(impl_->statics, shape, impl_->meshes);
  dGeomSetData(geom, impl_->own(shape.surface, -1));
  impl_->bounds.add(shape, geom);
}

void ContactSolver::set_terrain(std::shared_ptr<const Terrain> terrain) {
  impl_->terrain.emplace(std::move(terrain), impl_->own(Surface{}, -1));
}

void ContactSolver::add_body(std::span<const Shape> shapes, const MassProperties& mass) {
  Body body;
  body.id = dBodyCreate(impl_->world);
  body.space = dSimpleSpaceCreate(nullptr);
  const auto index = static_cast<std::ptrdiff_t>(impl_->bodies.size());
  for (const Shape& shape : shapes) {
    const dGeomID geom = make_geom(body.space, shape, impl_->meshes);
    dGeomSetData(geom, impl_->own(shape.surface, index));
    dGeomSetBody(geom, body.id);
    const Eigen::Vector3d p = shape.pose.translation();
    dReal q[4];
    to_ode(Eigen::Quaterniond(shape.pose.linear()), q);
    dGeomSetOffsetPosition(geom, p.x(), p.y(), p.z());
    dGeomSetOffsetQuaternion(geom, q);
    body.radius = std::max(body.radius, bounding_radius(shape));
  }
  dBodyDisable(body.id);
  body.world_contacts.reserve(kMostContacts);
  impl_->bodies.push_back(std::move(body));
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
  impl_->bodies[body].mass = mass;
}

bool ContactSolver::near_world(std::size_t body, const Eigen::Vector3d& p_W) const {
  return world_within(p_W, impl_->bodies[body].radius);
}

bool ContactSolver::near_each_other(std::size_t a, const Eigen::Vector3d& p_a_W, std::size_t b,
                                    const Eigen::Vector3d& p_b_W) const {
  const double reach = impl_->bodies[a].radius + impl_->bodies[b].radius;
  return (p_a_W - p_b_W).squaredNorm() <= reach * reach;
}

void ContactSolver::begin(double dt) {
  impl_->h = dt;
  dJointGroupEmpty(impl_->joints);
  impl_->contacts.clear();
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

void ContactSolver::collide_world(std::size_t index) {
  Body& body = impl_->bodies[index];
  if (!body.looked || !Impl::touches_the_same(body)) impl_->look_for_world_contacts(body);
  impl_->add_world_contacts(body);
}

bool ContactSolver::collide_bodies(std::size_t a, std::size_t b) {
  impl_->points.clear();
  dSpaceCollide2(reinterpret_cast<dGeomID>(impl_->bodies[a].space),
                 reinterpret_cast<dGeomID>(impl_->bodies[b].space), impl_.get(), &Impl::on_pair);
  if (impl_->points.empty()) return false;
  impl_->keep_points(impl_->contacts);
  impl_->bodies[a].touching = true;
  impl_->bodies[b].touching = true;
  return true;
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

void ContactSolver::step() {
  impl_->make_joints();
  if (OdeMessages::step(impl_->world, impl_->h)) return;
  impl_->has_given_up = true;
  throw SolverFailure("the contact solver has given up (" + OdeMessages::error() +
                      "): a mass, an inertia, a size or a speed of a vehicle is out of all "
                      "proportion");
}

void ContactSolver::read(std::size_t body, BodyState& state) const {
  const dBodyID id = impl_->bodies[body].id;
  const dReal* q = dBodyGetQuaternion(id);
  state.p_WB = from_ode(dBodyGetPosition(id));
  state.v_WB = from_ode(dBodyGetLinearVel(id));
  state.q_WB = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  state.w_WB_B = state.q_WB.conjugate() * from_ode(dBodyGetAngularVel(id));
}

std::optional<RayHit> ContactSolver::ray_to_world(const Eigen::Vector3d& origin_W,
                                                  const Eigen::Vector3d& direction_W,
                                                  double range_m) const {
  const auto hit = impl_->cast(impl_->statics, origin_W, direction_W, range_m);
  if (!impl_->terrain) return hit;
  const auto ground =
      impl_->terrain->terrain().cast(origin_W, direction_W, hit ? hit->distance_m : range_m);
  return ground ? ground : hit;
}

std::optional<RayHit> ContactSolver::ray_to_body(std::size_t body, const Eigen::Vector3d& origin_W,
                                                 const Eigen::Vector3d& direction_W,
                                                 double range_m) const {
  return impl_->cast(impl_->bodies[body].space, origin_W, direction_W, range_m);
}

bool ContactSolver::world_within(const Eigen::Vector3d& p_W, double radius_m) const {
  return impl_->bounds.within(p_W, radius_m) ||
         (impl_->terrain && impl_->terrain->within(p_W, radius_m));
}

bool ContactSolver::touches_world(const Disc& disc) const {
  const StaticBounds& bounds = impl_->bounds;
  if (bounds.plane_cuts(disc.centre_W, disc.q_WD * Eigen::Vector3d::UnitZ(), disc.radius_m)) {
    return true;
  }
  const bool near_box = bounds.box_within(disc.centre_W, disc.radius_m);
  return (near_box && impl_->meets(disc, impl_->statics)) || impl_->meets_terrain(disc);
}

bool ContactSolver::touches_body(std::size_t body, const Disc& disc) const {
  return impl_->meets(disc, impl_->bodies[body].space);
}

double ContactSolver::height_above_ground(const Eigen::Vector3d& p_W) const {
  double height = impl_->bounds.height_above_planes(p_W);
  if (impl_->terrain) {
    const double ground_m = impl_->terrain->terrain().height_m(p_W.x(), p_W.y());
    height = std::min(height, p_W.z() - ground_m);
  }
  if (!impl_->bounds.box_below(p_W)) return height;
  const double range = p_W.z() - impl_->bounds.lowest_of_boxes() + 1.0;
  const auto hit = ray_to_world(p_W, -Eigen::Vector3d::UnitZ(), range);
  return hit ? std::min(height, hit->distance_m) : height;
}

double ContactSolver::radius(std::size_t body) const { return impl_->bodies[body].radius; }

std::uint64_t ContactSolver::complaints() { return OdeMessages::count(); }

void ContactSolver::reset() {
  dRandSetSeed(kOdeSeed);
  for (Body& body : impl_->bodies) {
    body.looked = false;
    body.asked = false;
    body.remembered.forget();
    body.world_contacts.clear();
  }
}

}  // namespace cas::sim
