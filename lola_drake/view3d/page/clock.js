// Inside Meshcat's page: whoever shows it in a frame gives it the time, and is told of its own.
const framed = window.parent !== window;

function tell(message) {
  if (framed) window.parent.postMessage({ replay: true, ...message }, "*");
}

window.addEventListener("message", ({ source, data }) => {
  if (source !== window.parent) return;
  if (data.time !== undefined) {
    if (viewer.animator.playing) viewer.animator.pause();
    viewer.animator.seek(data.time);
    viewer.animator.display_progress(data.time);
  }
  if (data.sky) sky(data.sky);
});

// Meshes come one by one, some after the recording: whatever is new in the ghosts becomes one.
function haunt() {
  const { world } = viewer.scene_tree.children;
  if (!world || !world.children.ghost) return;
  world.children.ghost.object.traverse(({ material }) => {
    for (const each of [].concat(material || [])) {
      if (each.ghost) continue;
      Object.assign(each, { ghost: true, transparent: true, opacity: 0.35, metalness: 0, needsUpdate: true });
      if (each.color) each.color.setRGB(0.45, 0.3, 0.95);
      viewer.set_dirty();
    }
  });
}
setInterval(haunt, 300);

// The recording arrives a moment after the page.
const waiting = setInterval(() => {
  const animator = viewer.animator;
  if (!animator.duration) return;
  clearInterval(waiting);
  if (!framed) return;
  animator.pause();
  animator.seek(0);
  tell({ ready: true });
  (function each() {
    if (animator.playing) tell({ time: animator.time });
    requestAnimationFrame(each);
  })();
}, 50);
