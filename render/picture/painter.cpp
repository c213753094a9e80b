#include "render/picture/painter.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "render/gl/context.h"
#include "render/gl/framebuffer.h"
#include "render/gl/opengl.h"
#include "render/gl/program.h"

namespace kirireel {
namespace {

/// Samples of a pixel, across and down: quicker and smoother here than 4 x multisampling.
constexpr int kSamplesAcross = 2;
constexpr int kSamplesDown = 3;

/// Largest part of a picture drawn at once, pixels: bounds the memory of large pictures.
constexpr int kMaxPartSide = 2048;

/// An outline takes no more than this part of what would leave nothing of the face's shortest side,
/// so that small and thin faces keep their colour.
constexpr double kMaxOutlineShare = 0.35;

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

constexpr const char* kMeanVertexShader = R"(#version 330 core
void main() {  // one triangle that covers everything
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
)";

// The samples hold premultiplied alpha, the means straight. Turns the rows over too: a frame
// starts at the top.
constexpr const char* kMeanFragmentShader = R"(#version 330 core
uniform sampler2D picture;
uniform float rows;
out vec4 colour;
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.x, rows - gl_FragCoord.y);
  ivec2 corner = pixel * ivec2(2, 3);
  vec4 sum = texelFetch(picture, corner, 0) + texelFetch(picture, corner + ivec2(1, 0), 0) +
             texelFetch(picture, corner + ivec2(0, 1), 0) +
             texelFetch(picture, corner + ivec2(1, 1), 0) +
             texelFetch(picture, corner + ivec2(0, 2), 0) +
             texelFetch(picture, corner + ivec2(1, 2), 0);
  colour = vec4(sum.rgb / max(sum.a, 1.0e-6), sum.a / 6.0);
}
)";
static_assert(kSamplesAcross == 2 && kSamplesDown == 3, "the shader above reads 2 x 3 samples");

/// What the face shaders read of one corner of a triangle.
struct Vertex {
  std::array<float, 4> clip;  ///< clip coordinates of the whole picture
  std::array<std::uint8_t, 4> colour;
};

/// A face in brick axes.
struct Face {
  std::vector<Vector3> corners;
  std::vector<Vector3> inwards;  ///< how the corners move when all sides move in by 1 m
  double maxOutline = 0;         ///< metres
  Vector3 normal;
  Colour base;
};

/// Twice the vector area (Newell), normalised: the outward normal of an anticlockwise polygon.
Vector3 polygonNormal(const std::vector<Vector3>& corners) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t k = 0; k < corners.size(); ++k) {
    sum += (corners[k] - corners[0]).cross(corners[(k + 1) % corners.size()] - corners[0]);
  }
  return sum.normalized();
}

/// The unit vector in the face's plane that leads inwards from side k.
Vector3 sideInwards(const Face& face, std::size_t k) {
  const std::vector<Vector3>& corners = face.corners;
  return face.normal.cross(corners[(k + 1) % corners.size()] - corners[k]).normalized();
}

/// Fills in how the face's outline is drawn.
void measureOutline(Face& face) {
  const std::size_t count = face.corners.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3 before = sideInwards(face, (k + count - 1) % count);
    const Vector3 after = sideInwards(face, k);
    face.inwards.push_back((before + after) / (1 + before.dot(after)));
  }
  face.maxOutline = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3 side = face.corners[(k + 1) % count] - face.corners[k];
    const double shrinking = side.normalized().dot(face.inwards[k] - face.inwards[(k + 1) % count]);
    if (shrinking <= 0) continue;
    face.maxOutline = std::min(face.maxOutline, kMaxOutlineShare * side.norm() / shrinking);
  }
}

std::vector<Face> shadedFaces(const Brick& brick, const Style& style) {
  std::vector<Face> faces;
  for (const std::vector<Vector3>& corners : brickFaces(brick)) {
    const Colour base = faces.empty() ? style.bottom : faces.size() == 1 ? style.top : style.side;
    Face face{corners, {}, 0, polygonNormal(corners), base};
    measureOutline(face);
    faces.push_back(std::move(face));
  }
  return faces;
}

std::array<std::uint8_t, 4> bytes(Colour colour) {
  return {colour.red, colour.green, colour.blue, colour.alpha};
}

std::array<float, 4> toClip(const Eigen::Matrix4d& clipFromAxes, const Vector3& point) {
  const Eigen::Vector4f clip = (clipFromAxes * point.homogeneous()).cast<float>();
  return {clip.x(), clip.y(), clip.z(), clip.w()};
}

/// What stays the same while the faces of one brick are drawn.
struct Drawing {
  Eigen::Matrix4d clipFromAxes;
  Colour edge;
  double outline = 0;  ///< width of the outline within one face, metres
};

/// Appends the face within its outline, and the outline as a band along each side.
void appendFace(const Face& face, const Drawing& drawing, Colour colour,
                std::vector<Vertex>& vertices) {
  const double outline = std::min(drawing.outline, face.maxOutline);
  std::vector<Vertex> outer, inner, band;
  for (std::size_t k = 0; k < face.corners.size(); ++k) {
    const auto rim = toClip(drawing.clipFromAxes, face.corners[k]);
    const auto border = toClip(drawing.clipFromAxes, face.corners[k] + outline * face.inwards[k]);
    outer.push_back({rim, bytes(drawing.edge)});
    band.push_back({border, bytes(drawing.edge)});
    inner.push_back({border, bytes(colour)});
  }
  for (std::size_t k = 2; k < inner.size(); ++k) {
    vertices.insert(vertices.end(), {inner[0], inner[k - 1], inner[k]});
  }
  if (outline <= 0) return;
  for (std::size_t k = 0; k < outer.size(); ++k) {
    const std::size_t next = (k + 1) % outer.size();
    vertices.insert(vertices.end(), {outer[k], outer[next], band[next]});
    vertices.insert(vertices.end(), {outer[k], band[next], band[k]});
  }
}

/// The plate as two triangles.
void appendGround(const GroundPlate& ground, const Eigen::Matrix4d& clipFromWorldAxes,
                  std::vector<Vertex>& vertices) {
  const auto corner = [&](double x, double y) {
    const Vector3 point(ground.centre.x() + x * ground.halfSize,
                        ground.centre.y() + y * ground.halfSize, ground.height);
    return Vertex{toClip(clipFromWorldAxes, point), bytes(ground.colour)};
  };
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, -1}, {1, 1}, {-1, 1}}) {
    vertices.push_back(corner(x, y));
  }
}

/// Height of the picture at the camera's centre, metres.
double heightAtCentre(const Camera& camera) {
  if (camera.orthographic) return camera.viewHeight;
  return 2 * std::tan(0.5 * camera.fieldOfView) * (camera.eye - camera.centre).norm();
}

Eigen::Matrix4d worldFromBrick(const Pose& pose) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.block<3, 3>(0, 0) = pose.rotation.toRotationMatrix();
  matrix.block<3, 1>(0, 3) = pose.position;
  return matrix;
}

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
    count_ = static_cast<GLsizei>(vertices.size());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)),
                 vertices.data(), GL_STREAM_DRAW);
  }

  void draw() const { glDrawArrays(GL_TRIANGLES, 0, count_); }

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
  GLsizei count_ = 0;
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

}  // namespace

/// Members in the order in which the context needs them made; it goes last.
struct Painter::Parts {
  FrameSize size;
  Style style;
  std::vector<std::vector<Face>> faces;  ///< by brick
  Context context;
  Framebuffer samples;
  Framebuffer means;
  Program facePainter;
  Program averager;
  VertexBuffer vertexBuffer;
  std::vector<Vertex> vertices;  ///< kept between frames for its memory

  Parts(FrameSize frameSize, const std::vector<Brick>& bricks, const Style& frameStyle);

  void collectVertices(const Poses& poses, const Camera& camera);
  void drawSamples(const PixelBox& part, const PixelBox& touched) const;
  void drawMeans(const PixelBox& part, const PixelBox& touched) const;
};

Painter::Parts::Parts(FrameSize frameSize, const std::vector<Brick>& bricks,
                      const Style& frameStyle)
    : size(validated(frameSize)),
      style(frameStyle),
      samples(std::min(size.width, kMaxPartSide) * kSamplesAcross,
              std::min(size.height, kMaxPartSide) * kSamplesDown, Framebuffer::Depth::Tested),
      means(std::min(size.width, kMaxPartSide), std::min(size.height, kMaxPartSide),
            Framebuffer::Depth::None),
      facePainter(kFaceVertexShader, kFaceFragmentShader),
      averager(kMeanVertexShader, kMeanFragmentShader) {
  for (const Brick& brick : bricks) faces.push_back(shadedFaces(brick, style));
  glEnable(GL_CULL_FACE);
  glDepthFunc(GL_LESS);
}

void Painter::Parts::collectVertices(const Poses& poses, const Camera& camera) {
  assert(poses.size() == faces.size());
  const Eigen::Matrix4d clipFromWorldAxes = clipFromWorld(camera, size.aspect());
  // Each of two flush faces draws half of the line between them.
  const double outline = 0.5 * style.edgeWidth * heightAtCentre(camera);
  vertices.clear();
  if (style.ground) appendGround(*style.ground, clipFromWorldAxes, vertices);
  for (std::size_t brick = 0; brick < faces.size(); ++brick) {
    const Drawing drawing{clipFromWorldAxes * worldFromBrick(poses[brick]), style.edge, outline};
    for (const Face& face : faces[brick]) {
      const Colour colour = faceColour(poses[brick].rotation * face.normal, face.base, style);
      appendFace(face, drawing, colour, vertices);
    }
  }
}

void Painter::Parts::drawSamples(const PixelBox& part, const PixelBox& touched) const {
  const Eigen::Vector2i sides = part.sizes();
  samples.drawInto(sides.x() * kSamplesAcross, sides.y() * kSamplesDown);
  glEnable(GL_DEPTH_TEST);
  const Colour& back = style.background;
  const float alpha = static_cast<float>(back.alpha) / 255.0F;
  const auto premultiplied = [alpha](std::uint8_t byte) {
    return static_cast<float>(byte) / 255.0F * alpha;
  };
  glClearColor(premultiplied(back.red), premultiplied(back.green), premultiplied(back.blue), alpha);
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
  vertexBuffer.draw();
}

void Painter::Parts::drawMeans(const PixelBox& part, const PixelBox& touched) const {
  means.drawInto(part.sizes().x(), part.sizes().y());
  glScissor(touched.min().x() - part.min().x(), touched.min().y() - part.min().y(),
            touched.sizes().x(), touched.sizes().y());
  glDisable(GL_DEPTH_TEST);
  averager.use();
  averager.set("rows", static_cast<float>(part.sizes().y()));
  samples.bindTexture();
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

Painter::Painter(FrameSize size, const std::vector<Brick>& bricks, const Style& style)
    : parts_(std::make_unique<Parts>(size, bricks, style)) {}

Painter::~Painter() {
  parts_->context.makeCurrent();
}

FrameSize Painter::size() const {
  return parts_->size;
}

Frame Painter::paint(const Poses& poses, const Camera& camera) {
  parts_->context.makeCurrent();
  parts_->collectVertices(poses, camera);
  parts_->vertexBuffer.load(parts_->vertices);
  Frame frame = makeFrame(size(), parts_->style.background);
  const PixelBox touched = touchedPixels(parts_->vertices, frame.size);
  for (const PixelBox& part : pictureParts(frame.size)) {
    const PixelBox inside = part.intersection(touched);
    if ((inside.max().array() <= inside.min().array()).any()) continue;
    parts_->drawSamples(part, inside);
    parts_->drawMeans(part, inside);
    parts_->means.read(inside.translated(-part.min()), frame.size.width,
                       frame.pixels.data() + frame.rowStart(inside.min().y()) +
                           static_cast<std::size_t>(inside.min().x()) * 4);
  }
  return frame;
}

}  // namespace kirireel
