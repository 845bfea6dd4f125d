#version 460
// One triangle over the whole target at the far plane; it covers the pixels without other geometry.

void main() {
    vec2 corner = vec2(gl_VertexIndex << 1 & 2, gl_VertexIndex & 2);
    gl_Position = vec4(corner * 2.0 - 1.0, 1.0, 1.0);
}
