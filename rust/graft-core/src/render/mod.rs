//! Ray casting: pictures without OpenGL.
