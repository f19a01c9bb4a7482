// A technique on a scene with a backend: what is timed.
#pragma once

#include "render/gl/context.h"
#include "validate/measured_scene.h"

namespace opaline {

class TechniqueRun {
 public:
  /// gl: the context of a gpu cell, else null. All must outlive it. Throws InputError for settings that are not valid.
  TechniqueRun(MeasuredScene& where, const Technique& what, const SettingValues& given, const gl::Context* gl)
      : scene(where), technique(what), settings(what.settings, given), gl_(gl) {}

  /// Prepares anew, to the end of all GPU work.
  void prepare() {
    prepared_.reset();
    prepared_ = gl_ ? technique.prepare_gpu(*scene.shared, settings, *gl_) : technique.prepare(*scene.shared, settings);
    if (gl_) gl_->finish();
  }
  /// Is something prepared, of the scene as it is? Edits forget it.
  bool is_prepared() const { return prepared_ != nullptr; }
  void forget() { prepared_.reset(); }
  /// One frame of the scene's present view, shaded, into `frame` and `image`.
  void render() {
    frame = prepared_->render(scene.shared->view);
    image = shade(scene.scene, scene.shared->view, frame);
  }

  MeasuredScene& scene;
  const Technique& technique;
  Settings settings;
  Frame frame;
  Image image;

 private:
  const gl::Context* gl_;
  std::unique_ptr<PreparedTechnique> prepared_;
};

}  // namespace opaline
