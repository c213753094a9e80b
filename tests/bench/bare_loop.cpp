#include "tests/bench/bare_loop.h"

#include <array>
#include <cstdint>

#include "render/picture/gl_context.h"
#include "render/picture/opengl.h"
#include "render/picture/picture_geometry.h"
#include "sim/generate/lattice.h"

namespace kirireel::bench {
namespace {

struct BareVertex {
  std::array<float, 4> clip;
  std::array<std::uint8_t, 4> colour;
};

/// The triangles of a geometry's faces.
std::vector<BareVertex> bareTriangles(const PaintedSheet& sheet) {
  picture::PictureGeometry geometry;
  picture::GeometryBuilder(sheet.bricks, {})
      .draw({sheet.poses, {}, {}, {}, {}}, sheet.camera, geometry);
  const Eigen::Matrix4d clip = picture::clipFromWorld(sheet.camera, kSize.aspect());
  std::vector<BareVertex> vertices;
  const auto add = [&](const Vector3& point, picture::Colour colour) {
    const Eigen::Vector4f place = (clip * point.homogeneous()).cast<float>();
    vertices.push_back({{place.x(), place.y(), place.z(), place.w()},
                        {colour.red, colour.green, colour.blue, colour.alpha}});
  };
  for (const picture::Facet& facet : geometry.solid) {
    const auto corners = geometry.corners(facet);
    for (std::size_t k = 2; k < corners.size(); ++k) {
      for (const std::size_t corner : {std::size_t{0}, k - 1, k}) {
        add(corners[corner], facet.colour);
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
    picture::glGenFramebuffers(1, &framebuffer);
    picture::glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    picture::glGenTextures(1, &texture);
    picture::glBindTexture(GL_TEXTURE_2D, texture);
    picture::glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                          nullptr);
    picture::glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    picture::glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    picture::glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture,
                                    0);
    picture::glGenRenderbuffers(1, &depth);
    picture::glBindRenderbuffer(GL_RENDERBUFFER, depth);
    picture::glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT32F, width, height);
    picture::glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth);
  }

  void drawInto(int width, int height) const {
    picture::glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    picture::glViewport(0, 0, width, height);
  }
};

}  // namespace

struct BareLoop::Parts {
  explicit Parts(const std::vector<BareVertex>& vertices)
      : samples(kSize.width * 2, kSize.height * 3),
        means(kSize.width, kSize.height),
        draw(kDrawVertex, kDrawFragment),
        mean(kMeanVertex, kMeanFragment),
        count(static_cast<GLsizei>(vertices.size())),
        pixels(std::size_t{4} * kSize.width * kSize.height) {
    picture::glGenVertexArrays(1, &array);
    picture::glGenBuffers(1, &buffer);
    picture::glBindVertexArray(array);
    picture::glBindBuffer(GL_ARRAY_BUFFER, buffer);
    picture::glBufferData(GL_ARRAY_BUFFER,
                          static_cast<GLsizeiptr>(vertices.size() * sizeof(BareVertex)),
                          vertices.data(), GL_STATIC_DRAW);
    picture::glEnableVertexAttribArray(0);
    picture::glEnableVertexAttribArray(1);
    picture::glVertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, sizeof(BareVertex), nullptr);
    picture::glVertexAttribPointer(1, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(BareVertex),
                                   reinterpret_cast<const void*>(offsetof(BareVertex, colour)));
    picture::glDepthFunc(GL_LESS);
    picture::glClearColor(1, 1, 1, 1);
  }

  void frame() {
    samples.drawInto(kSize.width * 2, kSize.height * 3);
    picture::glEnable(GL_DEPTH_TEST);
    picture::glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    draw.use();
    picture::glBindVertexArray(array);
    picture::glDrawArrays(GL_TRIANGLES, 0, count);
    means.drawInto(kSize.width, kSize.height);
    picture::glDisable(GL_DEPTH_TEST);
    mean.use();
    picture::glBindTexture(GL_TEXTURE_2D, samples.texture);
    picture::glDrawArrays(GL_TRIANGLES, 0, 3);
    picture::glReadPixels(0, 0, kSize.width, kSize.height, GL_RGBA, GL_UNSIGNED_BYTE,
                          pixels.data());
  }

  picture::Context context;
  Target samples;
  Target means;
  picture::Program draw;
  picture::Program mean;
  GLsizei count;
  std::vector<std::uint8_t> pixels;
  GLuint array = 0;
  GLuint buffer = 0;
};

PaintedSheet::PaintedSheet(int side) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = side;
  brick::BrickRule rule;
  rule.thickness = 0.1;
  const std::vector<model::Tile> tiles = generate::tessellationTiles(shape, 0.8);
  bricks = brick::makeBricks(tiles, rule);
  poses = brick::startPoses(tiles, bricks);
  picture::CameraFit fit;
  fit.aspect = kSize.aspect();
  camera = picture::fitCamera(picture::brickCorners(bricks, poses), fit);
}

BareLoop::BareLoop(const PaintedSheet& sheet)
    : parts_(std::make_unique<Parts>(bareTriangles(sheet))) {}

BareLoop::~BareLoop() = default;

void BareLoop::frame() {
  parts_->frame();
}

}  // namespace kirireel::bench
