// MuJoCo has no function that makes a model from numbers: it is written as a text in its own format
// and read from memory. The bricks that a breadth-first search along the hinges reaches are bodies
// within each other, their hinges joints; every other hinge closes a loop and is a "connect".
//
// MuJoCo's joints are exact, because its coordinates are joint angles. A "connect" is a soft
// constraint, so only closed loops have gaps. Model: E. Todorov, T. Erez, Y. Tassa, MuJoCo: A
// physics engine for model-based control, IROS 2012. Velocities cannot be written in joint
// coordinates without solving for them: a push by M v / t for the time t = kPush, with gravity off,
// gives accelerations whose t-fold are the joint velocities.
#include <array>
#include <cmath>
#include <cstring>
#include <deque>
#include <map>
#include <stdexcept>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "tests/bench/engines/other_worlds.h"

namespace kirireel::bench {
namespace {

// Loops are as stiff as MuJoCo allows: they close within two steps, the minimum, and are hardly
// compliant.
constexpr double kSoonClosed = 1e-5;
constexpr double kHard = 0.9999;
// Written velocities are those of a push of so many seconds.
constexpr double kPush = 1e-3;

template <auto Free>
struct MujocoDeleter {
  template <typename T>
  void operator()(T* thing) const {
    Free(thing);
  }
};
using MujocoModel = std::unique_ptr<mjModel, MujocoDeleter<mj_deleteModel>>;
using MujocoData = std::unique_ptr<mjData, MujocoDeleter<mj_deleteData>>;

std::string vectorWords(const Vector3& v) {
  return fmt::format("{} {} {}", v.x(), v.y(), v.z());
}

/// Two bricks and their common pivots: one, or two that span an axis.
struct PivotsOfPair {
  int a = 0;
  int b = 0;
  std::vector<brick::Pivot> pivots;
};

// By pairs of bricks, in the order of their numbers.
std::vector<PivotsOfPair> pairsOf(std::span<const brick::Pivot> pivots, bool planar) {
  std::map<std::pair<int, int>, PivotsOfPair> pairs;
  for (const brick::Pivot& pivot : pivots) {
    // In the plane both pivots of a hinge are the same constraint.
    if (planar && pivot.isUpper) continue;
    PivotsOfPair& pair = pairs[std::minmax(pivot.brickA, pivot.brickB)];
    pair.a = pivot.brickA;
    pair.b = pivot.brickB;
    pair.pivots.push_back(pivot);
  }
  std::vector<PivotsOfPair> list;
  for (auto& [bricks, pair] : pairs) list.push_back(std::move(pair));
  return list;
}

/// Writes the model as MuJoCo's text.
class MujocoText {
 public:
  MujocoText(const std::vector<brick::Brick>& bricks, const Poses& start,
             std::span<const brick::Pivot> pivots, const scene::Environment& environment,
             bool planar)
      : bricks_(bricks),
        start_(start),
        pairs_(pairsOf(pivots, planar)),
        gravity_(environment.gravity),
        planar_(planar),
        children_(bricks.size()),
        isPlaced_(bricks.size(), false) {}

  // Each brick that is not in a tree yet is the root of another one.
  std::string write() {
    std::string bodies;
    for (std::size_t k = 0; k < bricks_.size(); ++k) {
      if (isPlaced_[k]) continue;
      spanFrom(static_cast<int>(k));
      bodies += bodyText(static_cast<int>(k), Vector3::Zero(), rootJoints());
    }
    return fmt::format(
        "<mujoco><size njmax=\"{}\"/>"
        "<option gravity=\"{}\" integrator=\"Euler\"><flag contact=\"disable\"/></option>"
        "<default><equality solref=\"{} 1\" solimp=\"{} {} 0.001\"/></default>"
        "<worldbody>{}</worldbody><equality>{}</equality></mujoco>",
        // njmax: a loop has at most two connects of three rows each.
        6 * pairs_.size() + 1, vectorWords(gravity_), kSoonClosed, kHard, kHard, bodies, loops_);
  }

 private:
  struct Child {
    int brick;
    std::size_t pair;
  };

  // A tree's first brick is free.
  std::string rootJoints() const {
    if (!planar_) return "<freejoint/>";
    return "<joint type=\"slide\" axis=\"1 0 0\"/><joint type=\"slide\" axis=\"0 1 0\"/>"
           "<joint type=\"hinge\" axis=\"0 0 1\"/>";
  }

  /// Finds the tree below a brick, and writes the constraints that close its loops.
  void spanFrom(int root) {
    std::vector<bool> isUsed(pairs_.size(), false);
    std::deque<int> waiting = {root};
    isPlaced_[root] = true;
    while (!waiting.empty()) {
      const int brick = waiting.front();
      waiting.pop_front();
      // All pairs for each brick: O(bricks x pairs), which is short compared with MuJoCo's own
      // compilation.
      for (std::size_t p = 0; p < pairs_.size(); ++p) {
        const PivotsOfPair& pair = pairs_[p];
        if (isUsed[p] || (pair.a != brick && pair.b != brick)) continue;
        isUsed[p] = true;
        const int other = pair.a == brick ? pair.b : pair.a;
        if (isPlaced_[other]) {
          addLoop(pair);
          continue;
        }
        isPlaced_[other] = true;
        children_[brick].push_back({other, p});
        waiting.push_back(other);
      }
    }
  }

  void addLoop(const PivotsOfPair& pair) {
    for (const brick::Pivot& pivot : pair.pivots) {
      loops_ += fmt::format("<connect body1=\"b{}\" body2=\"b{}\" anchor=\"{}\"/>", pivot.brickA,
                            pivot.brickB, vectorWords(pivot.pointA));
    }
  }

  /// Bodies have the world's rotation at the start.
  std::string bodyText(int brick, const Vector3& parent, const std::string& joints) const {
    const Vector3 place = start_[brick].position;
    const Matrix3 turn = start_[brick].rotation.toRotationMatrix();
    // Bodies have the world's axes at the start. Their inertia is rotated into these.
    const Matrix3 inertia = turn * bricks_[brick].inertia * turn.transpose();
    std::string text = fmt::format(
        "<body name=\"b{}\" pos=\"{}\"><inertial pos=\"0 0 0\" mass=\"{}\" fullinertia=\"{} {} {} "
        "{} {} {}\"/>{}",
        brick, vectorWords(place - parent), bricks_[brick].mass, inertia(0, 0), inertia(1, 1),
        inertia(2, 2), inertia(0, 1), inertia(0, 2), inertia(1, 2), joints);
    for (const Child& child : children_[brick]) {
      text += bodyText(child.brick, place, jointText(child));
    }
    return text + "</body>";
  }

  // A hinge about the line through two pivots, a ball at one. In the plane a rotation about z.
  std::string jointText(const Child& child) const {
    const PivotsOfPair& pair = pairs_[child.pair];
    const auto pointOf = [&](const brick::Pivot& pivot) {
      return Vector3(pivot.brickA == child.brick ? pivot.pointA : pivot.pointB);
    };
    const Vector3 at = pointOf(pair.pivots.front());
    if (planar_)
      return fmt::format("<joint type=\"hinge\" axis=\"0 0 1\" pos=\"{}\"/>", vectorWords(at));
    if (pair.pivots.size() == 1)
      return fmt::format("<joint type=\"ball\" pos=\"{}\"/>", vectorWords(at));
    return fmt::format("<joint type=\"hinge\" axis=\"{}\" pos=\"{}\"/>",
                       vectorWords(pointOf(pair.pivots[1]) - at), vectorWords(at));
  }

  const std::vector<brick::Brick>& bricks_;
  const Poses& start_;
  std::vector<PivotsOfPair> pairs_;
  Vector3 gravity_;
  bool planar_;
  std::vector<std::vector<Child>> children_;
  std::vector<bool> isPlaced_;
  std::string loops_;
};

MujocoModel readModelText(const std::string& text) {
  // Hundreds of kilobytes, so not on the stack.
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  constexpr const char* kName = "bricks.xml";
  mj_makeEmptyFileVFS(files.get(), kName, static_cast<int>(text.size()));
  std::memcpy(files->filedata[mj_findFileVFS(files.get(), kName)], text.data(), text.size());
  std::array<char, 1000> fault{};
  MujocoModel model(mj_loadXML(kName, files.get(), fault.data(), fault.size()));
  mj_deleteVFS(files.get());
  if (!model) throw std::runtime_error(fmt::format("MuJoCo: {}", fault.data()));
  return model;
}

class MujocoWorld : public engines::BrickWorld {
 public:
  MujocoWorld(const std::vector<brick::Brick>& bricks, const Poses& start,
              std::span<const brick::Pivot> pivots, const scene::Environment& environment,
              bool planar)
      : bricks_(bricks),
        start_(start),
        environment_(environment),
        model_(readModelText(MujocoText(bricks, start, pivots, environment, planar).write())),
        data_(mj_makeData(model_.get())) {
    mju_user_warning = [](const char*) {};  // else they are written to a file in the current folder
    for (std::size_t k = 0; k < bricks.size(); ++k) {
      bodies_.push_back(mj_name2id(model_.get(), mjOBJ_BODY, fmt::format("b{}", k).c_str()));
    }
    // mj_step1 computes positions and velocities of all bodies, mj_step2 forces and the step: loads
    // come between the two.
    mj_step1(model_.get(), data_.get());
  }

  void applyLoad(int brick, const Vector3& force, const Vector3& torque) override {
    mjtNum* applied = data_->xfrc_applied + 6 * bodies_[brick];
    for (int k = 0; k < 3; ++k) {
      applied[k] += force[k];
      applied[3 + k] += torque[k];
    }
  }

  void advance(double step) override {
    model_->opt.timestep = step;
    damp();
    mj_step2(model_.get(), data_.get());
    std::fill_n(data_->xfrc_applied, 6 * model_->nbody, 0);
    mj_step1(model_.get(), data_.get());
  }

  void readMotion(Motion& motion) const override {
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      const mjtNum* place = data_->xipos + 3 * bodies_[k];
      const mjtNum* turn = data_->xquat + 4 * bodies_[k];
      motion.poses[k].position = {place[0], place[1], place[2]};
      motion.poses[k].rotation =
          Quaternion(turn[0], turn[1], turn[2], turn[3]) * start_[k].rotation;
      motion.velocities[k] = velocityOf(k);
    }
  }

  /// The motion that was read last need not be written.
  void writeMotion(const Motion& motion) override {
    if (data_->time > 0) return;
    const mjtNum gravity[3] = {model_->opt.gravity[0], model_->opt.gravity[1],
                               model_->opt.gravity[2]};
    std::fill_n(model_->opt.gravity, 3, 0);
    std::fill_n(data_->qvel, model_->nv, 0);
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      const auto& [linear, angular] = motion.velocities[k];
      applyLoad(static_cast<int>(k), bricks_[k].mass / kPush * linear,
                inertiaOf(k) * angular / kPush);
    }
    mj_forward(model_.get(), data_.get());
    for (int k = 0; k < model_->nv; ++k) data_->qvel[k] = kPush * data_->qacc[k];
    std::fill_n(data_->xfrc_applied, 6 * model_->nbody, 0);
    std::copy_n(gravity, 3, model_->opt.gravity);
    mj_step1(model_.get(), data_.get());
  }

 private:
  Velocity velocityOf(std::size_t brick) const {
    // MuJoCo's spatial vectors have the angular part first.
    mjtNum both[6];
    mj_objectVelocity(model_.get(), data_.get(), mjOBJ_BODY, bodies_[brick], both, 0);
    return {{both[3], both[4], both[5]}, {both[0], both[1], both[2]}};
  }

  /// In world axes.
  Matrix3 inertiaOf(std::size_t brick) const {
    const mjtNum* turn = data_->xquat + 4 * bodies_[brick];
    const Matrix3 now = (Quaternion(turn[0], turn[1], turn[2], turn[3]) * start_[brick].rotation)
                            .toRotationMatrix();
    return now * bricks_[brick].inertia * now.transpose();
  }

  /// The damping of the environment. MuJoCo has only damping of joints.
  void damp() {
    // The rate whose exponential loses this fraction per second. It acts explicitly, which is
    // enough for the small rates of studies.
    const double linear = -std::log1p(-environment_.linearDamping);
    const double angular = -std::log1p(-environment_.angularDamping);
    if (linear == 0 && angular == 0) return;
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      const Velocity velocity = velocityOf(k);
      applyLoad(static_cast<int>(k), -linear * bricks_[k].mass * velocity.linear,
                -angular * inertiaOf(k) * velocity.angular);
    }
  }

  std::vector<brick::Brick> bricks_;
  Poses start_;
  scene::Environment environment_;
  MujocoModel model_;
  MujocoData data_;
  std::vector<int> bodies_;  // one per brick, in order
};

}  // namespace

std::unique_ptr<engines::BrickWorld> makeMujocoWorld(const std::vector<brick::Brick>& bricks,
                                                     const Poses& start,
                                                     std::span<const brick::Pivot> pivots,
                                                     const scene::Environment& environment,
                                                     bool planar) {
  return std::make_unique<MujocoWorld>(bricks, start, pivots, environment, planar);
}

std::string mujocoVersion() {
  return mj_versionString();
}

}  // namespace kirireel::bench
