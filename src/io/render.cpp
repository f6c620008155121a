#include "io/render.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkWindowToImageFilter.h>

#include "core/error.hpp"

namespace porepack::io {
namespace {

vtkNew<vtkPolyData> poly_data(const TriangleSurface& surface) {
    vtkNew<vtkPoints> points;
    for (const auto& p : surface.points) points->InsertNextPoint(p.data());
    vtkNew<vtkCellArray> cells;
    for (const auto& t : surface.triangles) {
        cells->InsertNextCell(3);
        for (const int corner : t) cells->InsertCellPoint(corner);
    }
    vtkNew<vtkPolyData> data;
    data->SetPoints(points);
    data->SetPolys(cells);
    return data;
}

void add_walls(vtkRenderer* renderer, const TriangleSurface& walls) {
    vtkNew<vtkPolyDataNormals> normals;
    normals->SetInputData(poly_data(walls));
    normals->SetFeatureAngle(40.0);
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputConnection(normals->GetOutputPort());
    vtkNew<vtkActor> actor;
    actor->SetMapper(mapper);
    actor->GetProperty()->SetColor(0.55, 0.65, 0.75);
    actor->GetProperty()->SetOpacity(0.18);
    renderer->AddActor(actor);
}

}  // namespace

PictureStyle style_for(const TriangleSurface& surface) {
    std::array<double, 3> low = {1e300, 1e300, 1e300}, high = {-1e300, -1e300, -1e300};
    for (const auto& p : surface.points)
        for (std::size_t a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a]);
            high[a] = std::max(high[a], p[a]);
        }
    const double ratio = std::clamp((high[0] - low[0]) / std::max(1e-300, high[2] - low[2]), 0.5, 2.0);
    return {.width = static_cast<int>(1000.0 * std::sqrt(ratio)), .height = static_cast<int>(1000.0 / std::sqrt(ratio))};
}

void render_surface(const Path& png, const TriangleSurface& surface, const PictureStyle& style) {
    vtkNew<vtkPolyDataNormals> normals;
    normals->SetInputData(poly_data(surface));
    normals->SetFeatureAngle(40.0);
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputConnection(normals->GetOutputPort());
    vtkNew<vtkActor> grains;
    grains->SetMapper(mapper);
    grains->GetProperty()->SetColor(0.80, 0.62, 0.42);
    grains->GetProperty()->SetSpecular(0.15);
    grains->GetProperty()->SetAmbient(0.12);
    vtkNew<vtkRenderer> renderer;
    renderer->AddActor(grains);
    renderer->SetBackground(1.0, 1.0, 1.0);
    if (!style.walls.triangles.empty()) add_walls(renderer, style.walls);
    vtkNew<vtkRenderWindow> window;
    window->SetOffScreenRendering(1);
    window->SetSize(style.width, style.height);
    window->SetMultiSamples(8);
    window->AddRenderer(renderer);
    renderer->GetActiveCamera()->SetPosition(1.0, -2.0, 0.9);
    renderer->GetActiveCamera()->SetFocalPoint(0.0, 0.0, 0.0);
    renderer->GetActiveCamera()->SetViewUp(0.0, 0.0, 1.0);
    if (style.front) {
        renderer->GetActiveCamera()->SetPosition(0.0, -1.0, 0.0);
        renderer->GetActiveCamera()->ParallelProjectionOn();
    }
    renderer->ResetCamera();
    renderer->GetActiveCamera()->Zoom(style.front ? 1.7 : 1.25);
    window->Render();
    vtkNew<vtkWindowToImageFilter> grabber;
    grabber->SetInput(window);
    grabber->ReadFrontBufferOff();
    write_whole(png, [&](const Path& name) {
        vtkNew<vtkPNGWriter> writer;
        writer->SetFileName(name.c_str());
        writer->SetInputConnection(grabber->GetOutputPort());
        writer->Write();
        if (writer->GetErrorCode() != 0) throw MachineError("cannot write " + png.string());
    });
}

}  // namespace porepack::io
