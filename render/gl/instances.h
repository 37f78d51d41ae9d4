// What of a scene is seen in a band, as the shaders take it.
#pragma once

#include <array>
#include <map>
#include <vector>

#include "render/cast/prepared_scene.h"
#include "render/gl/context.h"
#include "render/gl/film_strip.h"

namespace seam::render::gl {

// Which of the surfaces that lie in one plane is seen: the later one, as lines on a carpet are.
// Found once for a frame; places are those of SceneInstant::primitives.
class PaintLayers {
 public:
  explicit PaintLayers(const SceneInstant& scene);
  // What to multiply a hit's nearness by.
  float nearness(const SceneInstant& scene, size_t place) const;

 private:
  struct Layer {
    uint16_t object_id;
    Shape shape;
    int layer;
  };
  std::vector<Layer> layers_;
};

// The colours of a frame whose surfaces have one each; the first is the background's.
class Palette {
 public:
  explicit Palette(const Colour& background) { index_of(background); }
  float index_of(const Colour& colour);
  const std::vector<Colour>& colours() const { return colours_; }

 private:
  std::map<std::array<float, 3>, int> places_;
  std::vector<Colour> colours_;
};

// Where what is drawn goes.
struct BandPlace {
  const Band& band;
  const Page& page;
  const StripScale& scale;
  const StripView& view;
};

// `prepared` are the shapes of `scene` that the band's rows can see. With a palette they are
// identified by their colours' places in it.
void add_shapes(const PreparedInstant& prepared, const SceneInstant& scene,
                const PaintLayers& layers, const BandPlace& place, const CameraRays& rays,
                bool lambert, Palette* palette, PageScene& out);

// The scene's meshes that the band's rows can see.
void add_meshes(const SceneInstant& scene, const std::vector<ClusteredMesh>& meshes,
                const BandPlace& place, const CameraRays& rays, const Lighting& lighting,
                Palette* palette, PageScene& out);

}  // namespace seam::render::gl
