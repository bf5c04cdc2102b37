// A buffer with several samples for each pixel, in which whole pictures are drawn.

const SAMPLES = 4;

export class Smooth {
  constructor(gl) {
    Object.assign(this, { gl, buffer: gl.createFramebuffer(), parts: [], width: 0, height: 0 });
    // A picture is shown only from a buffer of the format of the canvas, which no browser tells.
    this.format = [gl.RGB8, gl.RGBA8].find((format) => this.fits(format));
  }

  // The buffer, as large as the picture; none, which is the canvas itself, if none fits.
  of(width, height) {
    if (!this.format) return null;
    if (width !== this.width || height !== this.height) this.make(width, height, this.format);
    return this.buffer;
  }

  make(width, height, format) {
    const { gl } = this;
    Object.assign(this, { width, height });
    this.parts.forEach((part) => gl.deleteRenderbuffer(part));
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.buffer);
    const formats = [[format, gl.COLOR_ATTACHMENT0], [gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]];
    this.parts = formats.map(([own, place]) => {
      const part = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, part);
      gl.renderbufferStorageMultisample(gl.RENDERBUFFER, SAMPLES, own, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, part);
      return part;
    });
  }

  fits(format) {
    const { gl } = this;
    this.make(gl.drawingBufferWidth, gl.drawingBufferHeight, format);
    while (gl.getError() !== gl.NO_ERROR);
    this.show();
    return gl.getError() === gl.NO_ERROR;
  }

  // Shows on the canvas what is in the buffer.
  show() {
    const { gl, width, height } = this;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.buffer);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }
}
