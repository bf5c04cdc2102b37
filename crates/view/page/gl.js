// Programs of WebGL2.

// What draws, as far as the browser tells.
export function rendererOf(gl) {
  const told = gl.getExtension("WEBGL_debug_renderer_info");
  return String(gl.getParameter(told ? told.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
}

export function build(gl, code) {
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, code.vertex], [gl.FRAGMENT_SHADER, code.fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) {
      throw new Error(gl.getShaderInfoLog(shader) || "a shader is not understood");
    }
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
    throw new Error(gl.getProgramInfoLog(program) || "a program is not understood");
  }
  const uniforms = {};
  const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS);
  for (let k = 0; k < count; k++) {
    const { name, type } = gl.getActiveUniform(program, k);
    uniforms[name] = { at: gl.getUniformLocation(program, name), type };
  }
  return { program, uniforms };
}
