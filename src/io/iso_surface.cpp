#include "io/iso_surface.hpp"

#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPolyData.h>

namespace porepack::io {

TriangleSurface iso_surface(const GrayImage& image) {
    const Grid& grid = image.grid;
    vtkNew<vtkImageData> padded;  // values at points: the centres of the voxels, and one layer beyond
    padded->SetDimensions(grid.cells[0] + 2, grid.cells[1] + 2, grid.cells[2] + 2);
    padded->SetSpacing(grid.spacing_m.data());
    padded->SetOrigin(grid.centre(0, -1), grid.centre(1, -1), grid.centre(2, -1));
    padded->AllocateScalars(VTK_FLOAT, 1);
    auto* value = static_cast<float*>(padded->GetScalarPointer());
    for (int k = -1; k <= grid.cells[2]; ++k)
        for (int j = -1; j <= grid.cells[1]; ++j)
            for (int i = -1; i <= grid.cells[0]; ++i) {
                const bool inside = i >= 0 && j >= 0 && k >= 0 && i < grid.cells[0] && j < grid.cells[1] && k < grid.cells[2];
                *value++ = inside ? static_cast<float>(image.at(grid.index(i, j, k))) : 0.0F;
            }
    vtkNew<vtkFlyingEdges3D> edges;
    edges->SetInputData(padded);
    edges->SetValue(0, image.level);
    edges->ComputeNormalsOff();
    edges->ComputeGradientsOff();
    edges->ComputeScalarsOff();
    edges->Update();
    vtkPolyData* mesh = edges->GetOutput();
    TriangleSurface surface;
    surface.points.resize(static_cast<std::size_t>(mesh->GetNumberOfPoints()));
    for (std::size_t p = 0; p < surface.points.size(); ++p) {
        double at[3];
        mesh->GetPoint(static_cast<vtkIdType>(p), at);
        surface.points[p] = {at[0], at[1], at[2]};
    }
    const auto cells = vtk::TakeSmartPointer(mesh->GetPolys()->NewIterator());
    for (cells->GoToFirstCell(); !cells->IsDoneWithTraversal(); cells->GoToNextCell()) {
        vtkIdType count = 0;
        const vtkIdType* corners = nullptr;
        cells->GetCurrentCell(count, corners);
        surface.triangles.push_back({static_cast<int>(corners[0]), static_cast<int>(corners[1]), static_cast<int>(corners[2])});
    }
    return surface;
}

}  // namespace porepack::io
