/// Prints what a frame of the painter costs beside a bare loop that draws the same triangles from a
/// buffer filled once, averages the same samples and reads them back. Run by hand:
///   tests/bench/painting [BRICKS A SIDE] [FRAMES]
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>

#include "render/gl/context.h"
#include "render/gl/opengl.h"
#include "render/gl/program.h"
#include "render/picture/painter.h"
#include "sim/model/tessellation.h"

namespace kirireel {
namespace {

constexpr FrameSize kSize = {1280, 720};

double threadMilliseconds() {
  timespec time = {};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

/// CPU milliseconds of the quickest of several rounds: what disturbs a round only adds to it.
double leastCost(int frames, const std::function<void()>& frame) {
  constexpr int kRounds = 12;
  double least = 1e9;
  for (int round = 0; round < kRounds; ++round) {
    const double start = threadMilliseconds();
    for (int k = 0; k < frames; ++k) frame();
    least = std::min(least, (threadMilliseconds() - start) / frames);
  }
  return least;
}

/// Half-open squares, seen from a corner.
struct BenchScene {
  std::vector<Brick> bricks;
  Poses poses;
  Camera camera;

  explicit BenchScene(int side) {
    TessellationShape shape;
    shape.columns = shape.rows = side;
    BrickRule rule;
    rule.thickness = 0.1;
    const std::vector<Tile> tiles = tessellationTiles(shape, 0.8);
    bricks = makeBricks(tiles, rule);
    poses = startPoses(tiles, bricks);
    CameraFit fit;
    fit.aspect = kSize.aspect();
    camera = fitCamera(brickCorners(bricks, poses), fit);
  }
};

struct BareVertex {
  std::array<float, 4> clip;
  std::array<std::uint8_t, 4> colour;
};

/// The triangles of a sketch's faces and outlines.
std::vector<BareVertex> bareTriangles(const BenchScene& scene) {
  Sketch sketch;
  Sketcher(scene.bricks, {}).draw({scene.poses, {}, {}, {}, {}}, scene.camera, sketch);
  const Eigen::Matrix4d clip = clipFromWorld(scene.camera, kSize.aspect());
  std::vector<BareVertex> vertices;
  const auto add = [&](const Vector3& point, Colour colour) {
    const Eigen::Vector4f place = (clip * point.homogeneous()).cast<float>();
    vertices.push_back({{place.x(), place.y(), place.z(), place.w()},
                        {colour.red, colour.green, colour.blue, colour.alpha}});
  };
  for (const Facet& facet : sketch.solid) {
    const auto outer = sketch.corners(facet), inner = sketch.inner(facet);
    for (std::size_t k = 2; k < inner.size(); ++k) {
      for (const std::size_t corner : {std::size_t{0}, k - 1, k}) add(inner[corner], facet.colour);
    }
    for (std::size_t k = 0; k < outer.size(); ++k) {
      const std::size_t next = (k + 1) % outer.size();
      for (const Vector3& point :
           {outer[k], outer[next], inner[next], outer[k], inner[next], inner[k]}) {
        add(point, sketch.edge);
      }
    }
  }
  return vertices;
}

constexpr const char* kDrawVertex = R"(#version 330 core
layout(location = 0) in vec4 clip;
layout(location = 1) in vec4 colour;
flat out vec4 face;
void main() { gl_Position = clip; face = colour; }
)";
constexpr const char* kDrawFragment = R"(#version 330 core
flat in vec4 face;
out vec4 colour;
void main() { colour = face; }
)";
constexpr const char* kMeanVertex = R"(#version 330 core
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
)";
constexpr const char* kMeanFragment = R"(#version 330 core
uniform sampler2D picture;
out vec4 colour;
void main() {
  ivec2 corner = ivec2(gl_FragCoord.xy) * ivec2(2, 3);
  vec4 sum = vec4(0.0);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 2; ++x) sum += texelFetch(picture, corner + ivec2(x, y), 0);
  colour = sum / 6.0;
}
)";

/// A framebuffer whose colours are a texture, to be averaged from.
struct Target {
  GLuint framebuffer = 0;
  GLuint texture = 0;
  GLuint depth = 0;

  Target(int width, int height) {
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
    glGenRenderbuffers(1, &depth);
    glBindRenderbuffer(GL_RENDERBUFFER, depth);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT32F, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth);
  }

  void drawInto(int width, int height) const {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, width, height);
  }
};

class BareLoop {
 public:
  explicit BareLoop(const std::vector<BareVertex>& vertices)
      : samples_(kSize.width * 2, kSize.height * 3),
        means_(kSize.width, kSize.height),
        draw_(kDrawVertex, kDrawFragment),
        mean_(kMeanVertex, kMeanFragment),
        count_(static_cast<GLsizei>(vertices.size())),
        pixels_(std::size_t{4} * kSize.width * kSize.height) {
    glGenVertexArrays(1, &array_);
    glGenBuffers(1, &buffer_);
    glBindVertexArray(array_);
    glBindBuffer(GL_ARRAY_BUFFER, buffer_);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(BareVertex)),
                 vertices.data(), GL_STATIC_DRAW);
    glEnableVertexAttribArray(0);
    glEnableVertexAttribArray(1);
    glVertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, sizeof(BareVertex), nullptr);
    glVertexAttribPointer(1, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(BareVertex),
                          reinterpret_cast<const void*>(offsetof(BareVertex, colour)));
    glDepthFunc(GL_LESS);
    glClearColor(1, 1, 1, 1);
  }

  void frame() {
    samples_.drawInto(kSize.width * 2, kSize.height * 3);
    glEnable(GL_DEPTH_TEST);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    draw_.use();
    glBindVertexArray(array_);
    glDrawArrays(GL_TRIANGLES, 0, count_);
    means_.drawInto(kSize.width, kSize.height);
    glDisable(GL_DEPTH_TEST);
    mean_.use();
    glBindTexture(GL_TEXTURE_2D, samples_.texture);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glReadPixels(0, 0, kSize.width, kSize.height, GL_RGBA, GL_UNSIGNED_BYTE, pixels_.data());
  }

 private:
  Context context_;
  Target samples_;
  Target means_;
  Program draw_;
  Program mean_;
  GLsizei count_;
  std::vector<std::uint8_t> pixels_;
  GLuint array_ = 0;
  GLuint buffer_ = 0;
};

int run(int side, int frames) {
  setRasterThreads(0);
  const BenchScene scene(side);
  Painter painter(kSize, scene.bricks, {});
  const double painted = leastCost(frames, [&] { painter.paint(scene.poses, scene.camera); });
  BareLoop loop(bareTriangles(scene));
  const double bare = leastCost(frames, [&] { loop.frame(); });
  std::printf("%d bricks, %d x %d, CPU ms a frame: painter %.2f, bare loop %.2f, ratio %.2f\n",
              side * side, kSize.width, kSize.height, painted, bare, painted / bare);
  return 0;
}

}  // namespace
}  // namespace kirireel

int main(int count, char** arguments) {
  return kirireel::run(count > 1 ? std::atoi(arguments[1]) : 10,
                       count > 2 ? std::atoi(arguments[2]) : 10);
}
