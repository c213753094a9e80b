// A picture in five steps:
//
// - 1. GeometryBuilder makes flat polygons of the view of the camera
//   (geometry.h), in five layers: ground, shadow, solid, translucent,
//   overlay.
// - 2. Tessellator converts them to triangles in clip coordinates. Translucent polygons are first
//   cut and sorted from far to near (makePieces), since blending requires that order everywhere.
//   The visible outlines (visibleOutlines) are drawn over all faces: lines of constant width, as in
//   vector graphics, made of rectangles and of discs at their corners.
// - 3. The picture is divided into parts of at most 2048 x 1024 pixels that contain triangles.
//   The triangles of each part are drawn to a framebuffer of 2 x 3 samples per pixel: ground and
//   overlay in painting order, solid ones by depth, translucent ones blended over the
//   background.
// - 4. Samples are read back in strips of 8 rows and averaged to pixels (painter.h).
// - 5. Pixels without triangles keep the background.
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
#include "render/picture/picture_geometry.h"
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
  int groundEnd = 0;       ///< facets of the plate and the shadow: first, in painting order
  int solidEnd = 0;        ///< then those that hide each other by depth
  int translucentEnd = 0;  ///< then those that are blended, in painting order
  int linesEnd = 0;        ///< then outlines; the rest is the overlay
  bool hasTranslucentLines = false;

  int facetCount() const { return static_cast<int>(facets.size()); }
  void clear() {
    vertices.clear();
    indices.clear();
    facets.clear();
    hasTranslucentLines = false;
  }
};

/// Minimum width of lines in pictures of few pixels: thinner lines would break into dashes.
constexpr double kThinnestSlit = 0.8;
constexpr double kThinnestSilhouette = 1.2;

/// Corners of the disc that closes the end of a line.
constexpr int kCapSides = 12;

/// Converts facets and lines to triangles. Facets are convex, so each is a fan from its first
/// corner.
class Tessellator {
 public:
  Tessellator(const PictureGeometry& geometry, const Eigen::Matrix4d& clipFromWorldAxes,
              FrameSize size, TriangleMesh& mesh)
      : sketch_(geometry),
        clipFromWorld_(clipFromWorldAxes),
        half_(0.5 * size.width, 0.5 * size.height),
        mesh_(mesh) {}

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

  /// Each outline is nearer to the eye than the previous one and has one depth. If the lines of a
  /// translucent outline overlap, they are blended only once.
  void append(std::vector<VisibleOutline> outlines, const Style& style) {
    // Each blending rounds to bytes, so a fixed order makes the picture independent of the order of
    // bricks.
    std::erase_if(outlines, [](const VisibleOutline& outline) { return outline.lines.empty(); });
    if (std::ranges::any_of(outlines, [](const VisibleOutline& o) { return o.opacity < 1; })) {
      std::ranges::stable_sort(outlines, {}, [](const VisibleOutline& outline) {
        const Vector3& point = outline.lines[0].points[0];
        return std::tuple(outline.opacity, point.x(), point.y(), point.z());
      });
    }
    const double step = 1.9 / std::max<std::size_t>(1, outlines.size());
    double depth = 0.95;
    for (const auto& [lines, opacity] : outlines) {
      depth -= step;
      Colour colour = style.edge;
      colour.alpha = static_cast<std::uint8_t>(std::lround(opacity * colour.alpha));
      mesh_.hasTranslucentLines |= colour.alpha < 255;
      const std::array<std::uint8_t, 4> channels = bytes(colour);
      for (const auto& line : lines) {
        const double width = line.isSilhouette ? style.silhouetteWidth : style.slitWidth;
        const double thinnest = line.isSilhouette ? kThinnestSilhouette : kThinnestSlit;
        // In pixels; the picture's height is 2 half_.y.
        const double radius = std::max(half_.y() * width, 0.5 * thinnest);
        addFacet([&](ClipBox& place) {
          appendLine(line.points, radius, static_cast<float>(depth), channels, place);
        });
      }
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

  /// radius: half the line's width, pixels.
  void appendLine(const std::vector<Vector3>& points, double radius, float depth,
                  const std::array<std::uint8_t, 4>& channels, ClipBox& place) {
    const auto vertex = [&](const Eigen::Vector2d& pixel) {
      const Eigen::Vector2f clip = pixel.cwiseQuotient(half_).cast<float>();
      mesh_.vertices.push_back({{clip.x(), clip.y(), depth, 1}, channels});
      place.add(mesh_.vertices.back());
      return static_cast<GLuint>(mesh_.vertices.size() - 1);
    };
    Eigen::Vector2d before;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Eigen::Vector4d clip = clipFromWorld_ * points[k].homogeneous();
      const Eigen::Vector2d pixel = (clip.head<2>() / clip.w()).cwiseProduct(half_);
      const GLuint first = static_cast<GLuint>(mesh_.vertices.size());
      for (int side = 0; side < kCapSides; ++side) {
        const double angle = 2 * std::numbers::pi * side / kCapSides;
        vertex(pixel + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
        if (side > 1) triangle(first, first + side - 1, first + side);
      }
      if (k > 0 && pixel != before) {
        const Eigen::Vector2d along = (pixel - before).normalized();
        const Eigen::Vector2d across = radius * Eigen::Vector2d(-along.y(), along.x());
        const GLuint from = vertex(before - across);
        vertex(pixel - across);
        vertex(pixel + across);
        vertex(before + across);
        triangle(from, from + 1, from + 2);
        triangle(from, from + 2, from + 3);
      }
      before = pixel;
    }
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
  Eigen::Vector2d half_;  ///< half the sides of the picture, pixels
  TriangleMesh& mesh_;
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

  /// In pieces, since a draw call cannot be interrupted.
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
  /// Ends in `indices`: of the ground, the solid facets, the translucent ones, the outlines, the
  /// overlay.
  std::array<int, 5> layerEnds{};
  std::vector<SpanRaster::Sample> strip;  ///< before averaging
  SpanRaster spans;
  bool isFlat = false;  ///< whether the spans have the picture, not the framebuffer

  Parts(FrameSize frameSize, const std::vector<brick::Brick>& bricks, const Style& style,
        Smoothness smoothness);

  void collectTriangles(const PictureItems& items, const Camera& camera);
  bool hasOneDepth() const;
  void collectSpans();
  void fitSamples(const PixelBox& part);
  void chooseTriangles(const PixelBox& part);
  void drawSamples(const PixelBox& part, const PixelBox& touched) const;
  void drawLayers() const;
  void readMeans(const PixelBox& part, const TouchedPixels& touched, Frame& frame);
  void readStrip(const PixelBox& part, const PixelBox& box, Frame& frame);
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
void Painter::Parts::collectTriangles(const PictureItems& items, const Camera& camera) {
  subject.sketcher.draw(items, camera, geometry);
  mesh.clear();
  Tessellator tessellator(geometry, clipFromWorld(camera, size.aspect()), size, mesh);
  tessellator.append(geometry.ground);
  tessellator.append(geometry.shadow);
  mesh.groundEnd = mesh.facetCount();
  tessellator.append(geometry.solid);
  mesh.solidEnd = mesh.facetCount();
  tessellator.appendSorted(geometry.translucent, camera);
  mesh.translucentEnd = mesh.facetCount();
  const Style& style = subject.style;
  if (style.slitWidth > 0) {
    tessellator.append(
        visibleOutlines(geometry, drawnPieces(geometry, camera), camera, style.silhouetteWidth),
        style);
  }
  mesh.linesEnd = mesh.facetCount();
  tessellator.append(geometry.overlay);
}

/// Whether the picture is opaque, and depth hides nothing in it.
bool Painter::Parts::hasOneDepth() const {
  constexpr float kRounding = 1e-5F;  // of clip coordinates
  if (!subject.opaque || mesh.translucentEnd > mesh.solidEnd || mesh.hasTranslucentLines) {
    return false;
  }
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
  std::ranges::for_each(facets.subspan(mesh.solidEnd), add);
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
  const std::array<int, 5> ends = {mesh.groundEnd, mesh.solidEnd, mesh.translucentEnd,
                                   mesh.linesEnd, mesh.facetCount()};
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

/// Ground and shadow are below everything, lines above everything. Only bricks hide each other.
/// Opaque bricks hide translucent ones, which hide nothing.
void Painter::Parts::drawLayers() const {
  const auto [groundEnd, solidEnd, translucentEnd, linesEnd, end] = layerEnds;
  glDisable(GL_DEPTH_TEST);
  MeshBuffer::draw(0, groundEnd);
  glEnable(GL_DEPTH_TEST);
  MeshBuffer::draw(groundEnd, solidEnd);
  glEnable(GL_BLEND);
  glDepthMask(GL_FALSE);
  MeshBuffer::draw(solidEnd, translucentEnd);
  glDepthMask(GL_TRUE);
  if (mesh.hasTranslucentLines) {
    glClear(GL_DEPTH_BUFFER_BIT);
    MeshBuffer::draw(translucentEnd, linesEnd);
  }
  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  MeshBuffer::draw(mesh.hasTranslucentLines ? linesEnd : translucentEnd, end);
}

/// The part's uniform maps the picture's clip coordinates to the part's: x' = sx x + tx w, with sx
/// = width of the picture / width of the part, and the same for y, which points up.
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
  const PixelBox wanted(Eigen::Vector2i(left, lowest),
                        Eigen::Vector2i(left + rowSamples, lowest + rows * samplesDown));
  if (isFlat) {
    spans.read(wanted, bytes(subject.style.background), strip);
  } else {
    strip.resize(std::size_t(rowSamples) * rows * samplesDown);
    samples->read(wanted, rowSamples, strip.front().data());
  }
  for (int row = 0; row < rows; ++row) {
    const std::size_t first = std::size_t(rowSamples) * (rows - 1 - row) * samplesDown;
    averageRow(
        {strip[first].data(), rowSamples, subject.opaque, samplesDown}, columns,
        frame.pixels.data() + frame.rowStart(box.min().y() + row) + std::size_t{4} * box.min().x());
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
  parts_->collectTriangles(items, camera);
  Frame frame = makeFrame(size(), parts_->subject.style.background, std::move(storage));
  const TouchedPixels touched(parts_->mesh.facets, frame.size);
  parts_->isFlat = parts_->hasOneDepth();
  if (parts_->isFlat) {
    parts_->collectSpans();
    const PixelBox whole(Eigen::Vector2i(0, 0),
                         Eigen::Vector2i(frame.size.width, frame.size.height));
    parts_->readMeans(whole, touched, frame);
    return frame;
  }
  parts_->context.makeCurrent();
  MeshBuffer::loadVertices(parts_->mesh.vertices);
  for (const PixelBox& part : pictureParts(touched.all(), frame.size)) {
    parts_->fitSamples(part);
    parts_->chooseTriangles(part);
    parts_->drawSamples(part, part.intersection(touched.all()));
    parts_->readMeans(part, touched, frame);
  }
  return frame;
}

}  // namespace kirireel::picture
