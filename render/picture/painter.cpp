// A picture in five steps:
//
// - 1. GeometryBuilder makes flat polygons of the view of the camera
//   (picture_geometry.h), in five layers: ground, shadow, solid, translucent, overlay.
// - 2. Tessellator converts the first four to triangles in clip coordinates. Translucent polygons
//   are first cut and sorted from far to near (makePieces), since blending requires that order
//   everywhere.
// - 3. The picture is divided into parts of at most 2048 x 1024 pixels that contain triangles.
//   The triangles of each part are drawn to a framebuffer of 2 x 3 samples per pixel: ground in
//   painting order, solid ones by depth, translucent ones blended over the background.
// - 4. Samples are read back in strips of 8 rows and averaged to pixels (painter.h). Pixels without
//   triangles keep the background.
// - 5. The visible outlines (visibleOutlines) and the overlay are drawn over the pixels
//   (shape_raster.h): lines of constant width, as in vector graphics.
//
// In opaque pictures of a flat sheet seen from above depth hides nothing. They are drawn without
// OpenGL instead of steps 3 and 4, by spans of samples (span_raster.h), in less than half the time.
//
// Supersampling replaces multisampling: llvmpipe draws flat triangles quickly, and six samples with
// separate depths also smooth the intersections of faces. Coordinates are doubles up to clip
// coordinates, then floats.
//
// The result is independent of time, threads and earlier pictures: equal items give equal bytes.
#include "render/picture/painter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "render/picture/gl_context.h"
#include "render/picture/opengl.h"
#include "render/picture/shape_raster.h"
#include "render/picture/span_raster.h"
#include "sim/base/interruption.h"

namespace kirireel::picture {
namespace {

/// Largest part of a picture drawn at once, pixels. It limits a painter's memory for large
/// pictures. Smaller parts cost more than they gain from the processor's cache.
constexpr int kMostPartWidth = 2048;
constexpr int kMostPartHeight = 1024;

/// Parts begin and end at multiples of this, pixels, so they seldom change between frames.
constexpr int kPartStep = 64;

/// Number of pixel rows whose samples are read back at once, small enough for the processor's
/// cache.
constexpr int kStripRows = 8;

// Drawn at once: some thousands of bricks, 50 ms of one core.
constexpr int kIndicesDrawn = 3 * 65536;

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

/// Input of the face shaders for one corner of a triangle, 20 bytes. A triangle has the colour of
/// its last corner. GL_UNSIGNED_BYTE, normalised: 255 is 1.
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

/// A rectangle in clip coordinates: the picture is [-1, 1] from its left and lower borders.
struct ClipBox : Eigen::AlignedBox2f {
  void add(const Vertex& vertex) {
    const auto& [x, y, z, w] = vertex.clip;
    if (w > 0) {
      extend(Eigen::Vector2f(x / w, y / w));
    } else {
      // The projection of a triangle behind the eye is undefined, so it may cover the whole
      // picture.
      extend(Eigen::Vector2f(-1, -1)).extend(Eigen::Vector2f(1, 1));
    }
  }
};

/// The triangles of one facet. `first` and `end` count indices, not triangles.
struct FacetTriangles {
  ClipBox place;
  int first = 0;  ///< offset of its corners in the indices
  int end = 0;
};

/// The triangles of one picture.
struct TriangleMesh {
  std::vector<Vertex> vertices;
  std::vector<GLuint> indices;  ///< of vertices, three per triangle
  std::vector<FacetTriangles> facets;
  int groundEnd = 0;  ///< facets of the plate and the shadow: first, in painting order
  int solidEnd = 0;   ///< then those that hide each other by depth
  // The rest are blended, in painting order.

  int facetCount() const { return static_cast<int>(facets.size()); }
  void clear() {
    vertices.clear();
    indices.clear();
    facets.clear();
  }
};

/// Converts facets to triangles. Facets are convex, so each is a fan from its first corner.
class Tessellator {
 public:
  Tessellator(const PictureGeometry& geometry, const Eigen::Matrix4d& clipFromWorldAxes,
              TriangleMesh& mesh)
      : sketch_(geometry), clipFromWorld_(clipFromWorldAxes), mesh_(mesh) {}

  /// Cut at intersections and sorted from far to near.
  void appendSorted(const std::vector<Facet>& facets, const Camera& camera) {
    for (const Piece& piece : farthestFirst(makePieces(sketch_, facets, camera))) {
      addFacet([&](ClipBox& place) { appendFan(piece.outer.corners, piece.colour, place); });
    }
  }

  void append(const std::vector<Facet>& facets) {
    for (const Facet& facet : facets) {
      addFacet([&](ClipBox& place) { appendFan(sketch_.corners(facet), facet.colour, place); });
    }
  }

 private:
  /// appendTriangles: of one facet, with the box that they occupy.
  template <typename Append>
  void addFacet(const Append& appendTriangles) {
    checkInterruption();
    FacetTriangles& made = mesh_.facets.emplace_back();
    made.first = static_cast<int>(mesh_.indices.size());
    appendTriangles(made.place);
    made.end = static_cast<int>(mesh_.indices.size());
  }

  /// A convex polygon. Returns the index of its first corner.
  GLuint appendFan(std::span<const Vector3> corners, Colour colour, ClipBox& place) {
    const GLuint first = appendCorners(corners, colour, place);
    for (GLuint k = 2; k < corners.size(); ++k) triangle(first, first + k - 1, first + k);
    return first;
  }

  /// Returns the index of the first.
  GLuint appendCorners(std::span<const Vector3> points, Colour colour, ClipBox& place) {
    const auto first = static_cast<GLuint>(mesh_.vertices.size());
    const std::array<std::uint8_t, 4> channels = bytes(colour);
    for (const Vector3& point : points) {
      mesh_.vertices.push_back({toClip(clipFromWorld_, point), channels});
      place.add(mesh_.vertices.back());
    }
    return first;
  }

  void triangle(GLuint a, GLuint b, GLuint c) {
    mesh_.indices.push_back(a);
    mesh_.indices.push_back(b);
    mesh_.indices.push_back(c);
  }

  const PictureGeometry& sketch_;
  Eigen::Matrix4d clipFromWorld_;
  TriangleMesh& mesh_;
};

/// Minimum width of lines, pixels: they would be pale in small pictures. A video of 640 pixels
/// keeps the default widths.
constexpr double kThinnestSlit = 0.7;
constexpr double kThinnestSilhouette = 1.05;

/// Corners of the half disc that ends a line.
constexpr int kCapCorners = 7;

/// Draws outlines and the overlay as shapes over the picture.
class LineDrawer {
 public:
  LineDrawer(const Eigen::Matrix4d& clipFromWorldAxes, FrameSize size, ShapeRaster& shapes)
      : clipFromWorld_(clipFromWorldAxes), size_(size), shapes_(shapes) {}

  /// Where lines of a translucent outline overlap, they are as dark as one.
  void draw(std::vector<VisibleOutline> outlines, const Style& style) {
    // Each blending rounds to bytes, so a fixed order makes the picture independent of the order of
    // bricks.
    std::erase_if(outlines, [](const VisibleOutline& outline) { return outline.lines.empty(); });
    if (std::ranges::any_of(outlines, [](const VisibleOutline& o) { return o.opacity < 1; })) {
      std::ranges::stable_sort(outlines, {}, [](const VisibleOutline& outline) {
        const Vector3& point = outline.lines[0].points[0];
        return std::tuple(outline.opacity, point.x(), point.y(), point.z());
      });
    }
    for (const auto& [lines, opacity] : outlines) {
      checkInterruption();
      Colour colour = style.edge;
      colour.alpha = static_cast<std::uint8_t>(std::lround(opacity * colour.alpha));
      shapes_.begin(colour);
      for (const auto& line : lines) {
        const double width = line.isSilhouette ? style.silhouetteWidth : style.slitWidth;
        const double thinnest = line.isSilhouette ? kThinnestSilhouette : kThinnestSlit;
        drawLine(line.points, 0.5 * std::max(width * size_.height, thinnest));
      }
    }
  }

  void draw(const std::vector<Piece>& pieces) {
    for (const Piece& piece : pieces) {
      shapes_.begin(piece.colour);
      corners_.clear();
      for (const Vector3& corner : piece.outer.corners) corners_.push_back(toPixels(corner));
      shapes_.add(corners_);
    }
  }

 private:
  /// Pixels from the upper left corner.
  Eigen::Vector2d toPixels(const Vector3& point) const {
    const Eigen::Vector4d clip = clipFromWorld_ * point.homogeneous();
    return {0.5 * (1 + clip.x() / clip.w()) * size_.width,
            0.5 * (1 - clip.y() / clip.w()) * size_.height};
  }

  /// radius: half the line's width, pixels.
  void drawLine(const std::vector<Vector3>& points, double radius) {
    Eigen::Vector2d from = toPixels(points.front());
    for (std::size_t k = 1; k < points.size(); ++k) {
      const Eigen::Vector2d to = toPixels(points[k]);
      corners_.clear();
      const double angle = std::atan2(to.y() - from.y(), to.x() - from.x());
      appendCap(to, radius, angle);
      appendCap(from, radius, angle + std::numbers::pi);
      shapes_.add(corners_);
      from = to;
    }
  }

  /// angle: of the direction in which the line ends.
  void appendCap(const Eigen::Vector2d& centre, double radius, double angle) {
    for (int k = 0; k < kCapCorners; ++k) {
      const double turn = angle + std::numbers::pi * (double(k) / (kCapCorners - 1) - 0.5);
      corners_.emplace_back(centre + radius * Eigen::Vector2d(std::cos(turn), std::sin(turn)));
    }
  }

  Eigen::Matrix4d clipFromWorld_;
  FrameSize size_;
  ShapeRaster& shapes_;
  std::vector<Eigen::Vector2d> corners_;  ///< of one polygon, kept to reuse memory
};

/// The triangles of one frame in the graphics context. Vertex array, vertices and indices are bound
/// at construction and stay bound: the context has no others.
class MeshBuffer {
 public:
  MeshBuffer() {
    glGenVertexArrays(1, &array_);
    glGenBuffers(1, &vertices_);
    glGenBuffers(1, &indices_);
    glBindVertexArray(array_);
    glBindBuffer(GL_ARRAY_BUFFER, vertices_);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
    attribute(0, 4, GL_FLOAT, GL_FALSE, offsetof(Vertex, clip));
    attribute(1, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(Vertex, colour));
  }
  ~MeshBuffer() {
    glDeleteBuffers(1, &indices_);
    glDeleteBuffers(1, &vertices_);
    glDeleteVertexArrays(1, &array_);
  }
  MeshBuffer(const MeshBuffer&) = delete;
  MeshBuffer& operator=(const MeshBuffer&) = delete;

  static void loadVertices(const std::vector<Vertex>& vertices) {
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)),
                 vertices.data(), GL_STREAM_DRAW);
  }
  static void loadIndices(const std::vector<GLuint>& indices) {
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size() * sizeof(GLuint)),
                 indices.data(), GL_STREAM_DRAW);
  }

  /// Draws in pieces, since a draw call cannot be interrupted.
  static void draw(int first, int end) {
    for (; first < end; first += kIndicesDrawn) {
      checkInterruption();
      glDrawElements(GL_TRIANGLES, std::min(kIndicesDrawn, end - first), GL_UNSIGNED_INT,
                     asPointer(sizeof(GLuint) * first));
      if (first + kIndicesDrawn < end) glFinish();
    }
  }

 private:
  /// OpenGL takes offsets as pointers.
  static const void* asPointer(std::size_t offset) {
    return reinterpret_cast<const void*>(offset);  // NOLINT(performance-no-int-to-ptr)
  }

  static void attribute(GLuint location, GLint channels, GLenum type, GLboolean normalised,
                        std::size_t offset) {
    glEnableVertexAttribArray(location);
    glVertexAttribPointer(location, channels, type, normalised, sizeof(Vertex), asPointer(offset));
  }

  GLuint array_ = 0;
  GLuint vertices_ = 0;
  GLuint indices_ = 0;
};

/// A rectangle of the picture, pixels from its top left corner, excluding right and lower.
using PixelBox = Eigen::AlignedBox2i;

bool hasNoPixel(const PixelBox& box) {
  return (box.max().array() <= box.min().array()).any();
}

/// The parts of a picture's touched pixels that are drawn at once; empty if there are none. Row by
/// row from the top.
std::vector<PixelBox> pictureParts(const PixelBox& touched, FrameSize size) {
  std::vector<PixelBox> parts;
  if (hasNoPixel(touched)) return parts;
  const Eigen::Array2i first = touched.min().array() / kPartStep * kPartStep;
  const Eigen::Array2i last = ((touched.max().array() + kPartStep - 1) / kPartStep * kPartStep)
                                  .min(Eigen::Array2i(size.width, size.height));
  for (int upper = first.y(); upper < last.y(); upper += kMostPartHeight) {
    for (int left = first.x(); left < last.x(); left += kMostPartWidth) {
      parts.emplace_back(Eigen::Vector2i(left, upper),
                         Eigen::Vector2i(std::min(left + kMostPartWidth, last.x()),
                                         std::min(upper + kMostPartHeight, last.y())));
    }
  }
  return parts;
}

/// The pixels that triangles can touch; all others show the background and need no work. One box
/// for the picture and one for each strip of rows. A margin of one pixel covers rounding.
class TouchedPixels {
 public:
  TouchedPixels(const std::vector<FacetTriangles>& facets, FrameSize size)
      : strips_((size.height + kStripRows - 1) / kStripRows) {
    const Eigen::Array2d corner(size.width, size.height);
    const auto inPicture = [&](const Eigen::Array2d& point) {
      return Eigen::Vector2i(point.max(0).min(corner).cast<int>().matrix());
    };
    for (const FacetTriangles& facet : facets) {
      const Eigen::Array2d least = facet.place.min().cast<double>().array();
      const Eigen::Array2d most = facet.place.max().cast<double>().array();
      const Eigen::Array2d upper = Eigen::Array2d(1 + least.x(), 1 - most.y()) * 0.5 * corner;
      const Eigen::Array2d lower = Eigen::Array2d(1 + most.x(), 1 - least.y()) * 0.5 * corner;
      add({inPicture(upper.floor() - 1), inPicture(lower.ceil() + 1)});
    }
  }

  /// A box around all touched pixels.
  const PixelBox& all() const { return all_; }

  /// A box around those in rows upper to upper + kStripRows - 1; upper is a multiple of kStripRows.
  const PixelBox& strip(int upper) const { return strips_[upper / kStripRows]; }

 private:
  void add(const PixelBox& box) {
    if (hasNoPixel(box)) return;
    all_.extend(box);
    for (int upper = box.min().y() / kStripRows * kStripRows; upper < box.max().y();
         upper += kStripRows) {
      const PixelBox rows(Eigen::Vector2i(box.min().x(), upper),
                          Eigen::Vector2i(box.max().x(), upper + kStripRows));
      strips_[upper / kStripRows].extend(rows.intersection(box));
    }
  }

  PixelBox all_;
  std::vector<PixelBox> strips_;
};

/// The painter's data without the graphics context.
struct PaintedBricks {
  GeometryBuilder sketcher;
  Style style;
  bool opaque;  ///< whether all pixels have alpha 255

  PaintedBricks(const std::vector<brick::Brick>& bricks, const Style& picturesStyle)
      : sketcher(bricks, picturesStyle),
        style(picturesStyle),
        opaque(style.background.alpha == 255 && style.shadow.alpha == 255) {}
};

}  // namespace

/// Members are in the order of their construction; the context is destroyed last.
struct Painter::Parts {
  FrameSize size;
  int samplesDown;  ///< per pixel
  PaintedBricks subject;
  Context context;
  std::optional<Framebuffer> samples;  ///< as large as the current part
  Program facePainter;
  MeshBuffer meshBuffer;
  // Kept between frames to reuse memory.
  PictureGeometry geometry;
  TriangleMesh mesh;
  std::vector<GLuint> indices;  ///< of the triangles of one part
  /// Ends in `indices`: of the ground, the solid facets, the translucent ones.
  std::array<int, 3> layerEnds{};
  std::vector<SpanRaster::Sample> strip;  ///< before averaging
  SpanRaster spans;
  ShapeRaster shapes;
  bool isFlat = false;  ///< whether the spans have the picture, not the framebuffer

  Parts(FrameSize frameSize, const std::vector<brick::Brick>& bricks, const Style& style,
        Smoothness smoothness);

  void collectTriangles(const Camera& camera);
  bool hasOneDepth() const;
  void collectSpans();
  void fitSamples(const PixelBox& part);
  void chooseTriangles(const PixelBox& part);
  void drawSamples(const PixelBox& part, const PixelBox& touched) const;
  void drawLayers() const;
  void readMeans(const PixelBox& part, const TouchedPixels& touched, Frame& frame);
  void readStrip(const PixelBox& part, const PixelBox& box, Frame& frame);
  void drawFaces(Frame& frame);
  void drawLines(const Camera& camera, Frame& frame);
};

Painter::Parts::Parts(FrameSize frameSize, const std::vector<brick::Brick>& bricks,
                      const Style& style, Smoothness smoothness)
    : size(requireValidSize(frameSize)),
      samplesDown(smoothness == Smoothness::Still ? kMostSamplesDown : 2),
      subject(bricks, style),
      facePainter(kFaceVertexShader, kFaceFragmentShader) {
  glDepthFunc(GL_LESS);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);  // of premultiplied colours
}

/// Fills the mesh.
void Painter::Parts::collectTriangles(const Camera& camera) {
  mesh.clear();
  Tessellator tessellator(geometry, clipFromWorld(camera, size.aspect()), mesh);
  tessellator.append(geometry.ground);
  tessellator.append(geometry.shadow);
  mesh.groundEnd = mesh.facetCount();
  tessellator.append(geometry.solid);
  mesh.solidEnd = mesh.facetCount();
  tessellator.appendSorted(geometry.translucent, camera);
}

void Painter::Parts::drawLines(const Camera& camera, Frame& frame) {
  shapes.clear(size);
  LineDrawer drawer(clipFromWorld(camera, size.aspect()), size, shapes);
  const Style& style = subject.style;
  if (style.slitWidth > 0) {
    drawer.draw(
        visibleOutlines(geometry, drawnPieces(geometry, camera), camera, style.silhouetteWidth),
        style);
  }
  drawer.draw(makePieces(geometry, geometry.overlay, camera));
  shapes.draw(frame);
}

/// Whether the picture is opaque, and depth hides nothing in it.
bool Painter::Parts::hasOneDepth() const {
  constexpr float kRounding = 1e-5F;  // of clip coordinates
  if (!subject.opaque || mesh.facetCount() > mesh.solidEnd) return false;
  for (const auto& [clip, colour] : mesh.vertices) {
    if (clip[3] != 1 || std::abs(clip[2]) > 1 || colour[3] < 255) return false;
  }
  float nearest = 1, farthest = -1;
  for (int facet = mesh.groundEnd; facet < mesh.solidEnd; ++facet) {
    for (int k = mesh.facets[facet].first; k < mesh.facets[facet].end; ++k) {
      const float depth = mesh.vertices[mesh.indices[k]].clip[2];
      nearest = std::min(nearest, depth);
      farthest = std::max(farthest, depth);
    }
  }
  return farthest - nearest < kRounding;
}

/// Of solid facets in one plane, the first is visible, as with GL_LESS.
void Painter::Parts::collectSpans() {
  const Eigen::Vector2d half(0.5 * size.width * kSamplesAcross, 0.5 * size.height * samplesDown);
  spans.clear(size.height * samplesDown, kStripRows * samplesDown);
  const auto add = [&](const FacetTriangles& facet) {
    for (int k = facet.first; k < facet.end; k += 3) {
      std::array<Eigen::Vector2d, 3> corners;
      for (int corner = 0; corner < 3; ++corner) {
        const std::array<float, 4>& clip = mesh.vertices[mesh.indices[k + corner]].clip;
        corners[corner] = (Eigen::Vector2d(clip[0], clip[1]).array() + 1) * half.array();
      }
      spans.add(corners, mesh.vertices[mesh.indices[k + 2]].colour);
    }
  };
  const auto facets = std::span(mesh.facets);
  std::ranges::for_each(facets.first(mesh.groundEnd), add);
  const auto solid = facets.subspan(mesh.groundEnd, mesh.solidEnd - mesh.groundEnd);
  std::for_each(solid.rbegin(), solid.rend(), add);
}

/// Most pictures of a run have parts of the same size, so the framebuffer is seldom made.
void Painter::Parts::fitSamples(const PixelBox& part) {
  const Eigen::Vector2i requested(part.sizes().x() * kSamplesAcross,
                                  part.sizes().y() * samplesDown);
  if (samples && samples->sides() == requested) return;
  samples.reset();
  samples.emplace(requested.x(), requested.y());
}

/// Selects triangles that may touch the rows of a part.
void Painter::Parts::chooseTriangles(const PixelBox& part) {
  const auto heightOf = [this](int row) { return static_cast<float>(1 - 2.0 * row / size.height); };
  // A margin of one row on each side for rounding.
  const float lower = heightOf(part.max().y() + 1), upper = heightOf(part.min().y() - 1);
  indices.clear();
  int facet = 0;
  const std::array<int, 3> ends = {mesh.groundEnd, mesh.solidEnd, mesh.facetCount()};
  for (std::size_t layer = 0; layer < ends.size(); ++layer) {
    for (; facet < ends[layer]; ++facet) {
      const auto& [place, first, end] = mesh.facets[facet];
      if (place.max().y() < lower || place.min().y() > upper) continue;
      indices.insert(indices.end(), mesh.indices.begin() + first, mesh.indices.begin() + end);
    }
    layerEnds[layer] = static_cast<int>(indices.size());
  }
  MeshBuffer::loadIndices(indices);
}

/// Ground and shadow are below everything. Only bricks hide each other. Opaque bricks hide
/// translucent ones, which hide nothing.
void Painter::Parts::drawLayers() const {
  const auto [groundEnd, solidEnd, end] = layerEnds;
  glDisable(GL_DEPTH_TEST);
  MeshBuffer::draw(0, groundEnd);
  glEnable(GL_DEPTH_TEST);
  MeshBuffer::draw(groundEnd, solidEnd);
  glEnable(GL_BLEND);
  glDepthMask(GL_FALSE);
  MeshBuffer::draw(solidEnd, end);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
}

/// The part's uniform maps the picture's clip coordinates to the part's: x' = sx x + tx w, with
/// sx = width of the picture / width of the part, and the same for y, which points up.
void Painter::Parts::drawSamples(const PixelBox& part, const PixelBox& touched) const {
  const Eigen::Vector2i sides = part.sizes();
  samples->drawInto();
  const std::array<std::uint8_t, 4> back = bytes(subject.style.background);
  const auto channel = [&back](int k) { return static_cast<float>(back[k]) / 255.0F; };
  glClearColor(channel(0), channel(1), channel(2), channel(3));
  // Clearing everything is faster here than clearing a box, for a framebuffer of this size.
  glDisable(GL_SCISSOR_TEST);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glEnable(GL_SCISSOR_TEST);
  glScissor((touched.min().x() - part.min().x()) * kSamplesAcross,
            (part.max().y() - touched.max().y()) * samplesDown,
            touched.sizes().x() * kSamplesAcross, touched.sizes().y() * samplesDown);

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

/// Reads back only touched rows.
void Painter::Parts::readMeans(const PixelBox& part, const TouchedPixels& touched, Frame& frame) {
  const PixelBox inside = part.intersection(touched.all());
  for (int upper = inside.min().y() / kStripRows * kStripRows; upper < inside.max().y();
       upper += kStripRows) {
    checkInterruption();
    // In pictures with alpha the whole box is read: untouched samples are transparent black, not
    // background.
    const PixelBox rows(Eigen::Vector2i(inside.min().x(), upper),
                        Eigen::Vector2i(inside.max().x(), upper + kStripRows));
    const PixelBox box = (subject.opaque ? touched.strip(upper) : rows).intersection(inside);
    if (!hasNoPixel(box)) readStrip(part, box, frame);
  }
}

/// Reads the pixels of a box of a few rows.
void Painter::Parts::readStrip(const PixelBox& part, const PixelBox& box, Frame& frame) {
  const auto [columns, rows] = std::pair(box.sizes().x(), box.sizes().y());
  const int left = (box.min().x() - part.min().x()) * kSamplesAcross;
  const int rowSamples = columns * kSamplesAcross;
  // OpenGL's rows start at the lower border.
  const int lowest = (part.max().y() - box.max().y()) * samplesDown;
  const PixelBox requested(Eigen::Vector2i(left, lowest),
                           Eigen::Vector2i(left + rowSamples, lowest + rows * samplesDown));
  if (isFlat) {
    spans.read(requested, bytes(subject.style.background), strip);
  } else {
    strip.resize(std::size_t(rowSamples) * rows * samplesDown);
    samples->read(requested, rowSamples, strip.front().data());
  }
  for (int row = 0; row < rows; ++row) {
    const std::size_t first = std::size_t(rowSamples) * (rows - 1 - row) * samplesDown;
    averageRow(
        {strip[first].data(), rowSamples, subject.opaque, samplesDown}, columns,
        frame.pixels.data() + frame.rowStart(box.min().y() + row) + std::size_t{4} * box.min().x());
  }
}

void Painter::Parts::drawFaces(Frame& frame) {
  const TouchedPixels touched(mesh.facets, size);
  isFlat = hasOneDepth();
  if (isFlat) {
    collectSpans();
    const PixelBox whole(Eigen::Vector2i(0, 0), Eigen::Vector2i(size.width, size.height));
    readMeans(whole, touched, frame);
    return;
  }
  context.makeCurrent();
  MeshBuffer::loadVertices(mesh.vertices);
  for (const PixelBox& part : pictureParts(touched.all(), size)) {
    fitSamples(part);
    chooseTriangles(part);
    drawSamples(part, part.intersection(touched.all()));
    readMeans(part, touched, frame);
  }
}

Painter::Painter(FrameSize size, const std::vector<brick::Brick>& bricks, const Style& style,
                 Smoothness smoothness)
    : parts_(std::make_unique<Parts>(size, bricks, style, smoothness)) {}

Painter::~Painter() {
  parts_->context.makeCurrent();
}

void Painter::show(const std::vector<brick::Brick>& bricks, const Style& style) {
  parts_->subject = PaintedBricks(bricks, style);
}

FrameSize Painter::size() const {
  return parts_->size;
}

Frame Painter::paint(const Poses& poses, const Camera& camera) {
  return paint(PictureItems{poses}, camera);
}

Frame Painter::paint(const PictureItems& items, const Camera& camera, Frame storage) {
  parts_->subject.sketcher.draw(items, camera, parts_->geometry);
  parts_->collectTriangles(camera);
  Frame frame = makeFrame(size(), parts_->subject.style.background, std::move(storage));
  parts_->drawFaces(frame);
  parts_->drawLines(camera, frame);
  return frame;
}

}  // namespace kirireel::picture
