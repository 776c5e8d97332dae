// How pictures in space are drawn where there is no graphics card.

/// Whether the processor draws: no smooth edges then, and fewer pixels while the view moves.
export function drawsSlowly() {
  const probe = document.createElement('canvas').getContext('webgl2'), about = probe?.getExtension('WEBGL_debug_renderer_info');
  const name = about ? probe.getParameter(about.UNMASKED_RENDERER_WEBGL) : '';
  probe?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

/// Makes the picture as large as its box, with half of the pixels a side where `isCoarse`. Null: there is no room to draw.
export function fitted(renderer, box, isCoarse) {
  const { clientWidth: width, clientHeight: height } = box, canvas = renderer.domElement;
  if (width < 10 || height < 10) return null;
  const ratio = (isCoarse ? 0.5 : 1) * Math.min(2, window.devicePixelRatio || 1);
  if (canvas.width !== Math.floor(width * ratio) || canvas.height !== Math.floor(height * ratio)) {
    renderer.setPixelRatio(ratio);
    renderer.setSize(width, height, false);
  }
  return { width, height, ratio };
}
