#include "render/picture/painter.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>

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

/// No face loses more than this part of its height to its outline, so that small faces keep colour.
constexpr double kMaxOutlineShare = 0.2;

constexpr const char* kFaceVertexShader = R"(#version 330 core
layout(location = 0) in vec4 clip;
layout(location = 1) in float inwards;
layout(location = 2) in vec4 colour;
uniform vec4 part;  // scale and shift from the picture's clip coordinates to the part's
out float height;
flat out vec4 face;
void main() {
  gl_Position = vec4(clip.xy * part.xy + clip.w * part.zw, clip.zw);
  height = inwards;
  face = colour;
}
)";

// height grows from 0 at the face's border; divided by its slope it is a distance in pixels.
constexpr const char* kFaceFragmentShader = R"(#version 330 core
in float height;
flat in vec4 face;
uniform vec2 samples;
uniform float outline;       // half width, pixels
uniform float outlineShare;
uniform vec4 edge;
out vec4 colour;
void main() {
  float slope = length(vec2(dFdx(height), dFdy(height)) * samples);
  colour = height < min(outline * slope, outlineShare) ? edge : face;
}
)";

constexpr const char* kMeanVertexShader = R"(#version 330 core
void main() {  // one triangle that covers everything
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
)";

// Turns the rows over too: a frame starts at the top.
constexpr const char* kMeanFragmentShader = R"(#version 330 core
uniform sampler2D picture;
uniform float rows;
out vec4 colour;
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.x, rows - gl_FragCoord.y);
  ivec2 corner = pixel * ivec2(2, 3);
  vec3 sum = vec3(0.0);
  float weight = 0.0;
  for (int k = 0; k < 6; ++k) {
    vec4 value = texelFetch(picture, corner + ivec2(k % 2, k / 2), 0);
    sum += value.rgb * value.a;
    weight += value.a;
  }
  colour = vec4(sum / max(weight, 1.0e-6), weight / 6.0);
}
)";
static_assert(kSamplesAcross == 2 && kSamplesDown == 3, "the shader above reads 2 x 3 samples");

/// What the face shaders read of one corner of a triangle.
struct Vertex {
  std::array<float, 4> clip;  ///< clip coordinates of the whole picture
  float inwards = 0;          ///< 0 on the face's border, 1 in its middle
  std::array<std::uint8_t, 4> colour;
};

/// A face in brick axes.
struct Face {
  std::vector<Vector3> corners;
  Vector3 middle;
  Vector3 normal;
  Colour base;
};

Vector3 meanPoint(const std::vector<Vector3>& points) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

/// Twice the vector area (Newell), normalised: the outward normal of an anticlockwise polygon.
Vector3 polygonNormal(const std::vector<Vector3>& corners) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t k = 0; k < corners.size(); ++k) {
    sum += (corners[k] - corners[0]).cross(corners[(k + 1) % corners.size()] - corners[0]);
  }
  return sum.normalized();
}

std::vector<Face> shadedFaces(const Brick& brick, const Style& style) {
  std::vector<Face> faces;
  for (const std::vector<Vector3>& corners : brickFaces(brick)) {
    const Colour base = faces.empty() ? style.bottom : faces.size() == 1 ? style.top : style.side;
    faces.push_back({corners, meanPoint(corners), polygonNormal(corners), base});
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

/// Appends the triangles between a face's middle and its edges.
void appendFace(const Face& face, const Eigen::Matrix4d& clipFromAxes, Colour colour,
                std::vector<Vertex>& vertices) {
  const Vertex middle{toClip(clipFromAxes, face.middle), 1, bytes(colour)};
  const std::size_t count = face.corners.size();
  Vertex last{toClip(clipFromAxes, face.corners[0]), 0, bytes(colour)};
  for (std::size_t k = 1; k <= count; ++k) {
    const Vertex next{toClip(clipFromAxes, face.corners[k % count]), 0, bytes(colour)};
    vertices.insert(vertices.end(), {middle, last, next});
    last = next;
  }
}

/// The plate as two triangles without outline: all of it counts as the middle of a face.
void appendGround(const GroundPlate& ground, const Eigen::Matrix4d& clipFromWorldAxes,
                  std::vector<Vertex>& vertices) {
  const auto corner = [&](double x, double y) {
    const Vector3 point(ground.centre.x() + x * ground.halfSize,
                        ground.centre.y() + y * ground.halfSize, ground.height);
    return Vertex{toClip(clipFromWorldAxes, point), 1, bytes(ground.colour)};
  };
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, -1}, {1, 1}, {-1, 1}}) {
    vertices.push_back(corner(x, y));
  }
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
    attribute(1, 1, GL_FLOAT, GL_FALSE, offsetof(Vertex, inwards));
    attribute(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(Vertex, colour));
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
    glVertexAttribPointer(location, channels, type, normalised, sizeof(Vertex),
                          reinterpret_cast<const void*>(offset));
  }

  GLuint array_ = 0;
  GLuint buffer_ = 0;
  GLsizei count_ = 0;
};

/// A rectangle of the picture, pixels from its top left corner.
struct PicturePart {
  int left, upper, width, height;
};

std::vector<PicturePart> pictureParts(FrameSize size) {
  std::vector<PicturePart> parts;
  for (int upper = 0; upper < size.height; upper += kMaxPartSide) {
    for (int left = 0; left < size.width; left += kMaxPartSide) {
      parts.push_back({left, upper, std::min(kMaxPartSide, size.width - left),
                       std::min(kMaxPartSide, size.height - upper)});
    }
  }
  return parts;
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
  void drawSamples(const PicturePart& part) const;
  void drawMeans(const PicturePart& part) const;
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
  vertices.clear();
  if (style.ground) appendGround(*style.ground, clipFromWorldAxes, vertices);
  for (std::size_t brick = 0; brick < faces.size(); ++brick) {
    const Eigen::Matrix4d clipFromBrick = clipFromWorldAxes * worldFromBrick(poses[brick]);
    for (const Face& face : faces[brick]) {
      const Colour colour = faceColour(poses[brick].rotation * face.normal, face.base, style);
      appendFace(face, clipFromBrick, colour, vertices);
    }
  }
}

void Painter::Parts::drawSamples(const PicturePart& part) const {
  samples.drawInto(part.width * kSamplesAcross, part.height * kSamplesDown);
  glEnable(GL_DEPTH_TEST);
  const auto share = [](std::uint8_t byte) { return static_cast<float>(byte) / 255.0F; };
  const Colour& back = style.background;
  glClearColor(share(back.red), share(back.green), share(back.blue), share(back.alpha));
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);

  facePainter.use();
  const double scaleX = static_cast<double>(size.width) / part.width;
  const double scaleY = static_cast<double>(size.height) / part.height;
  const double shiftX = scaleX - 1 - 2.0 * part.left / part.width;
  const double shiftY = 1 - scaleY + 2.0 * part.upper / part.height;
  facePainter.set("part", static_cast<float>(scaleX), static_cast<float>(scaleY),
                  static_cast<float>(shiftX), static_cast<float>(shiftY));
  facePainter.set("samples", kSamplesAcross, kSamplesDown);
  facePainter.set("outline", static_cast<float>(0.5 * style.edgeWidth * size.height));
  facePainter.set("outlineShare", kMaxOutlineShare);
  facePainter.set("edge", share(style.edge.red), share(style.edge.green), share(style.edge.blue),
                  share(style.edge.alpha));
  vertexBuffer.draw();
}

void Painter::Parts::drawMeans(const PicturePart& part) const {
  means.drawInto(part.width, part.height);
  glDisable(GL_DEPTH_TEST);
  averager.use();
  averager.set("rows", static_cast<float>(part.height));
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
  Frame frame{size(), {}};
  frame.pixels.resize(frame.rowStart(frame.size.height));
  for (const PicturePart& part : pictureParts(frame.size)) {
    parts_->drawSamples(part);
    parts_->drawMeans(part);
    parts_->means.read(
        part.width, part.height, frame.size.width,
        frame.pixels.data() + frame.rowStart(part.upper) + static_cast<std::size_t>(part.left) * 4);
  }
  return frame;
}

}  // namespace kirireel
