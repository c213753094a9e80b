#include "render/picture/painter.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "render/gl/context.h"
#include "render/gl/framebuffer.h"
#include "render/gl/opengl.h"
#include "render/gl/program.h"
#include "render/picture/average.h"
#include "sim/base/interruption.h"

namespace kirireel {
namespace {

/// Largest part of a picture drawn at once, pixels: bounds the memory of large pictures.
constexpr int kMaxPartSide = 2048;

/// Rows of pixels whose samples are read back at once: few enough to stay in the processor's cache
/// until they are averaged.
constexpr int kStripRows = 8;

// Drawn at once: some thousands of bricks, 50 ms of a core.
constexpr int kVerticesDrawn = 3 * 65536;

constexpr const char* kFaceVertexShader = R"(#version 330 core
layout(location = 0) in vec4 clip;
layout(location = 1) in vec4 colour;
uniform vec4 part;  // scale and shift from the picture's clip coordinates to the part's
flat out vec4 face;
void main() {
  gl_Position = vec4(clip.xy * part.xy + clip.w * part.zw, clip.zw);
  face = colour;
}
)";

constexpr const char* kFaceFragmentShader = R"(#version 330 core
flat in vec4 face;
out vec4 colour;
void main() { colour = face; }
)";

/// What the face shaders read of one corner of a triangle.
struct Vertex {
  std::array<float, 4> clip;  ///< clip coordinates of the whole picture
  std::array<std::uint8_t, 4> colour;
};

/// The samples hold premultiplied alpha.
std::array<std::uint8_t, 4> bytes(Colour colour) {
  const auto premultiplied = [&colour](std::uint8_t channel) {
    return static_cast<std::uint8_t>((channel * colour.alpha + 127) / 255);
  };
  return {premultiplied(colour.red), premultiplied(colour.green), premultiplied(colour.blue),
          colour.alpha};
}

std::array<float, 4> toClip(const Eigen::Matrix4d& clipFromAxes, const Vector3& point) {
  const Eigen::Vector4f clip = (clipFromAxes * point.homogeneous()).cast<float>();
  return {clip.x(), clip.y(), clip.z(), clip.w()};
}

/// The triangles of one picture, and where its layers end.
struct Triangles {
  std::vector<Vertex> vertices;
  int groundEnd = 0;  ///< vertices of the plate and the shadow: first, in painting order
  int solidEnd = 0;   ///< then those that hide each other by depth; the rest is laid over

  int count() const { return static_cast<int>(vertices.size()); }
};

/// Turns facets into triangles: the face within its outline, and the outline as a band along each
/// side.
class Tessellator {
 public:
  Tessellator(const Sketch& sketch, const Eigen::Matrix4d& clipFromWorldAxes,
              std::vector<Vertex>& vertices)
      : sketch_(sketch), clipFromWorld_(clipFromWorldAxes), vertices_(vertices) {}

  void append(const std::vector<Facet>& facets) {
    for (const Facet& facet : facets) {
      checkInterruption();
      append(facet);
    }
  }

 private:
  void append(const Facet& facet) {
    project(sketch_.inner(facet), inner_);
    const auto face = bytes(facet.colour);
    for (std::size_t k = 2; k < inner_.size(); ++k) {
      triangle({inner_[0], face}, {inner_[k - 1], face}, {inner_[k], face});
    }
    if (facet.outlined) appendOutline(facet);
  }

  void appendOutline(const Facet& facet) {
    project(sketch_.corners(facet), outer_);
    const auto edge = bytes(sketch_.edge);
    for (std::size_t k = 0; k < outer_.size(); ++k) {
      const std::size_t next = (k + 1) % outer_.size();
      triangle({outer_[k], edge}, {outer_[next], edge}, {inner_[next], edge});
      triangle({outer_[k], edge}, {inner_[next], edge}, {inner_[k], edge});
    }
  }

  void project(std::span<const Vector3> points, std::vector<std::array<float, 4>>& clip) const {
    clip.clear();
    for (const Vector3& point : points) clip.push_back(toClip(clipFromWorld_, point));
  }

  void triangle(const Vertex& a, const Vertex& b, const Vertex& c) {
    vertices_.push_back(a);
    vertices_.push_back(b);
    vertices_.push_back(c);
  }

  const Sketch& sketch_;
  Eigen::Matrix4d clipFromWorld_;
  std::vector<Vertex>& vertices_;
  std::vector<std::array<float, 4>> outer_, inner_;  ///< of one facet, in clip coordinates
};

/// The triangles of one frame, as the graphics context holds them.
class VertexBuffer {
 public:
  VertexBuffer() {
    glGenVertexArrays(1, &array_);
    glGenBuffers(1, &buffer_);
    glBindVertexArray(array_);
    glBindBuffer(GL_ARRAY_BUFFER, buffer_);
    attribute(0, 4, GL_FLOAT, GL_FALSE, offsetof(Vertex, clip));
    attribute(1, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(Vertex, colour));
  }
  ~VertexBuffer() {
    glDeleteBuffers(1, &buffer_);
    glDeleteVertexArrays(1, &array_);
  }
  VertexBuffer(const VertexBuffer&) = delete;
  VertexBuffer& operator=(const VertexBuffer&) = delete;

  void load(const std::vector<Vertex>& vertices) {
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)),
                 vertices.data(), GL_STREAM_DRAW);
  }

  /// In pieces, since nothing can end what is being drawn.
  static void draw(int first, int end) {
    for (; first < end; first += kVerticesDrawn) {
      checkInterruption();
      glDrawArrays(GL_TRIANGLES, first, std::min(kVerticesDrawn, end - first));
      if (first + kVerticesDrawn < end) glFinish();
    }
  }

 private:
  static void attribute(GLuint location, GLint channels, GLenum type, GLboolean normalised,
                        std::size_t offset) {
    glEnableVertexAttribArray(location);
    glVertexAttribPointer(
        location, channels, type, normalised, sizeof(Vertex),
        // OpenGL takes the offset as a pointer.
        reinterpret_cast<const void*>(offset));  // NOLINT(performance-no-int-to-ptr)
  }

  GLuint array_ = 0;
  GLuint buffer_ = 0;
};

/// A rectangle of the picture, pixels from its top left corner; right and lower are not in it.
using PixelBox = Eigen::AlignedBox2i;

std::vector<PixelBox> pictureParts(FrameSize size) {
  std::vector<PixelBox> parts;
  for (int upper = 0; upper < size.height; upper += kMaxPartSide) {
    for (int left = 0; left < size.width; left += kMaxPartSide) {
      parts.emplace_back(Eigen::Vector2i(left, upper),
                         Eigen::Vector2i(std::min(left + kMaxPartSide, size.width),
                                         std::min(upper + kMaxPartSide, size.height)));
    }
  }
  return parts;
}

/// The pixels that triangles can touch: elsewhere there is background, not worth any drawing.
PixelBox touchedPixels(const std::vector<Vertex>& vertices, FrameSize size) {
  const Eigen::Array2d corner(size.width, size.height);
  Eigen::AlignedBox2d box;
  for (const Vertex& vertex : vertices) {
    const auto& [x, y, z, w] = vertex.clip;
    // Behind the eye there is no telling where a triangle goes.
    if (w <= 0) return {Eigen::Vector2i(0, 0), Eigen::Vector2i(size.width, size.height)};
    box.extend(Eigen::Vector2d((Eigen::Array2d(1 + x / w, 1 - y / w) * 0.5 * corner).matrix()));
  }
  if (box.isEmpty()) return {};
  const auto inPicture = [&](const Eigen::Array2d& point) {
    return Eigen::Vector2i(point.max(0).min(corner).cast<int>().matrix());
  };
  return {inPicture(box.min().array().floor() - 1), inPicture(box.max().array().ceil() + 1)};
}

/// Refuses a bad size before any graphics memory is asked for.
FrameSize validated(FrameSize size) {
  requireValidSize(size);
  return size;
}

/// What is painted, apart from the graphics context.
struct Subject {
  Sketcher sketcher;
  Colour background;
  bool opaque;  ///< whether nothing that is drawn has another alpha than 255

  Subject(const std::vector<Brick>& bricks, const Style& style)
      : sketcher(bricks, style),
        background(style.background),
        opaque(style.background.alpha == 255 && style.shadow.alpha == 255) {}
};

}  // namespace

/// Members in the order in which the context needs them made; it goes last.
struct Painter::Parts {
  FrameSize size;
  Subject subject;
  Context context;
  Framebuffer samples;
  Program facePainter;
  VertexBuffer vertexBuffer;
  // Kept between frames for their memory.
  Sketch sketch;
  Triangles triangles;
  std::vector<std::uint8_t> strip;  ///< samples on their way to a frame

  Parts(FrameSize frameSize, const std::vector<Brick>& bricks, const Style& style);

  void collectTriangles(const Shot& shot, const Camera& camera);
  void drawSamples(const PixelBox& part, const PixelBox& touched) const;
  void drawLayers() const;
  void readMeans(const PixelBox& part, const PixelBox& touched, Frame& frame);
};

Painter::Parts::Parts(FrameSize frameSize, const std::vector<Brick>& bricks, const Style& style)
    : size(validated(frameSize)),
      subject(bricks, style),
      samples(std::min(size.width, kMaxPartSide) * kSamplesAcross,
              std::min(size.height, kMaxPartSide) * kSamplesDown),
      facePainter(kFaceVertexShader, kFaceFragmentShader) {
  glDepthFunc(GL_LESS);
}

void Painter::Parts::collectTriangles(const Shot& shot, const Camera& camera) {
  subject.sketcher.draw(shot, camera, sketch);
  triangles.vertices.clear();
  Tessellator tessellator(sketch, clipFromWorld(camera, size.aspect()), triangles.vertices);
  tessellator.append(sketch.ground);
  tessellator.append(sketch.shadow);
  triangles.groundEnd = triangles.count();
  tessellator.append(sketch.solid);
  triangles.solidEnd = triangles.count();
  tessellator.append(sketch.overlay);
}

void Painter::Parts::drawLayers() const {
  if (triangles.groundEnd > 0) {
    glDisable(GL_DEPTH_TEST);
    VertexBuffer::draw(0, triangles.groundEnd);
  }
  glEnable(GL_DEPTH_TEST);
  VertexBuffer::draw(triangles.groundEnd, triangles.solidEnd);
  if (triangles.count() == triangles.solidEnd) return;
  glDisable(GL_DEPTH_TEST);
  VertexBuffer::draw(triangles.solidEnd, triangles.count());
}

void Painter::Parts::drawSamples(const PixelBox& part, const PixelBox& touched) const {
  const Eigen::Vector2i sides = part.sizes();
  samples.drawInto(sides.x() * kSamplesAcross, sides.y() * kSamplesDown);
  const std::array<std::uint8_t, 4> back = bytes(subject.background);
  const auto channel = [&back](int k) { return static_cast<float>(back[k]) / 255.0F; };
  glClearColor(channel(0), channel(1), channel(2), channel(3));
  // Clearing everything is quicker here than clearing a box.
  glDisable(GL_SCISSOR_TEST);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glEnable(GL_SCISSOR_TEST);
  glScissor((touched.min().x() - part.min().x()) * kSamplesAcross,
            (part.max().y() - touched.max().y()) * kSamplesDown,
            touched.sizes().x() * kSamplesAcross, touched.sizes().y() * kSamplesDown);

  const Eigen::Array2d scale =
      Eigen::Array2d(size.width, size.height) / sides.array().cast<double>();
  const Eigen::Array2d shift =
      2.0 * part.min().array().cast<double>() / sides.array().cast<double>();
  facePainter.use();
  facePainter.set("part", static_cast<float>(scale.x()), static_cast<float>(scale.y()),
                  static_cast<float>(scale.x() - 1 - shift.x()),
                  static_cast<float>(1 - scale.y() + shift.y()));
  drawLayers();
}

void Painter::Parts::readMeans(const PixelBox& part, const PixelBox& touched, Frame& frame) {
  const int left = (touched.min().x() - part.min().x()) * kSamplesAcross;
  const int rowSamples = touched.sizes().x() * kSamplesAcross;
  strip.resize(std::size_t{4} * rowSamples * kStripRows * kSamplesDown);
  for (int upper = touched.min().y(); upper < touched.max().y(); upper += kStripRows) {
    checkInterruption();
    const int rows = std::min(kStripRows, touched.max().y() - upper);
    // OpenGL's rows start at the lower border.
    const int lowest = (part.max().y() - upper - rows) * kSamplesDown;
    samples.read({Eigen::Vector2i(left, lowest),
                  Eigen::Vector2i(left + rowSamples, lowest + rows * kSamplesDown)},
                 rowSamples, strip.data());
    for (int row = 0; row < rows; ++row) {
      const std::size_t first = std::size_t{4} * rowSamples * (rows - 1 - row) * kSamplesDown;
      averageRow(
          {strip.data() + first, rowSamples, subject.opaque}, touched.sizes().x(),
          frame.pixels.data() + frame.rowStart(upper + row) + std::size_t{4} * touched.min().x());
    }
  }
}

Painter::Painter(FrameSize size, const std::vector<Brick>& bricks, const Style& style)
    : parts_(std::make_unique<Parts>(size, bricks, style)) {}

Painter::~Painter() {
  parts_->context.makeCurrent();
}

void Painter::show(const std::vector<Brick>& bricks, const Style& style) {
  parts_->subject = Subject(bricks, style);
}

FrameSize Painter::size() const {
  return parts_->size;
}

Frame Painter::paint(const Poses& poses, const Camera& camera) {
  return paint(Shot{poses}, camera);
}

Frame Painter::paint(const Shot& shot, const Camera& camera) {
  parts_->context.makeCurrent();
  parts_->collectTriangles(shot, camera);
  parts_->vertexBuffer.load(parts_->triangles.vertices);
  Frame frame = makeFrame(size(), parts_->subject.background);
  const PixelBox touched = touchedPixels(parts_->triangles.vertices, frame.size);
  for (const PixelBox& part : pictureParts(frame.size)) {
    const PixelBox inside = part.intersection(touched);
    if ((inside.max().array() <= inside.min().array()).any()) continue;
    parts_->drawSamples(part, inside);
    parts_->readMeans(part, inside, frame);
  }
  return frame;
}

}  // namespace kirireel
