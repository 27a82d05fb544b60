// Mouse, pen and fingers on the picture.

// handlers: orbit(dx, dy), pan(dx, dy), dolly(factor), point(x, y), click(x, y); distances as shares of the picture's height, places of
// its size.
export function watchPointer(canvas, handlers) {
  const fingers = new Map();
  let travelled = 0;
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  };
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return Math.hypot(a.x - b.x, a.y - b.y);
  };
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    if (fingers.size === 0) travelled = 0;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  canvas.addEventListener('pointermove', (event) => {
    const finger = fingers.get(event.pointerId);
    if (!finger) return handlers.point(...place(event));
    const height = canvas.getBoundingClientRect().height;
    const dx = (event.clientX - finger.x) / height;
    const dy = (event.clientY - finger.y) / height;
    const before = fingers.size === 2 ? spread() : 0;
    Object.assign(finger, { x: event.clientX, y: event.clientY });
    travelled += Math.hypot(dx, dy);
    if (fingers.size === 2) {
      handlers.pan(dx / 2, dy / 2);
      if (before > 0 && spread() > 0) handlers.dolly(before / spread());
    } else if (event.shiftKey || event.buttons & 6) {
      handlers.pan(dx, dy);
    } else {
      handlers.orbit(dx, dy);
    }
  });
  const end = (event) => {
    if (!fingers.delete(event.pointerId)) return;
    if (event.type === 'pointerup' && fingers.size === 0 && travelled < 0.01) handlers.click(...place(event));
  };
  canvas.addEventListener('pointerup', end);
  canvas.addEventListener('pointercancel', end);
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    handlers.dolly(Math.exp(event.deltaY * (event.deltaMode === 0 ? 0.001 : 0.04)));
  }, { passive: false });
}
